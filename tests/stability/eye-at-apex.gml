% all rays start on a double root
%
% From its apex one sees the base of a cone from within, and beside it the wall behind.
#include "common.gml"

orange matte apply cone 90.0 rotatex 0.0 0.0 -1.0 translate
blue matte apply plane -90.0 rotatex 0.0 0.0 5.0 translate union
90.0 48 48 "base.ppm" flat apply
