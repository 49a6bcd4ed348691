% what is nearer than the epsilon is not there
%
% A needle 1e-8 thick and 3e-8 away is, scaled about the eye, a column without end.
#include "common.gml"

blue matte apply cylinder 0.0 -0.5 0.0 translate /rod
rod 1.0 1.0e8 1.0 scale 0.0 0.0 3.0 translate 0.0 0.0 -1.0 translate "column.ppm" sunny apply
rod 1.0e-8 1.0 1.0e-8 scale 0.0 0.0 3.0e-8 translate 0.0 0.0 -1.0 translate "needle.ppm" sunny apply
