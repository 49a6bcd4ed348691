% the apex is a double root and has no normal
%
% A cone with its apex toward the eye; on the axis there is ambient light only.
#include "common.gml"

[ 0.0 0.0 1.0 point 0.5 0.5 0.5 point light ] 0.25 0.25 0.25 point
white matte apply cone 90.0 rotatex "apex.ppm" lit apply
