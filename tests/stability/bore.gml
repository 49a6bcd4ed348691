% a = 0 for the ray along the axis of a cylinder
%
% A tube 1e9 long and the wall behind it. Only the ray along the axis gets through.
#include "common.gml"

orange matte apply cylinder
blue matte apply cylinder 0.0 -0.5 0.0 translate 0.5 2.0 0.5 scale difference
90.0 rotatex 1.0 1.0 1.0e9 scale
green matte apply plane -90.0 rotatex 0.0 0.0 2.0e9 translate union
90.0 49 49 "bore.ppm" flat apply
