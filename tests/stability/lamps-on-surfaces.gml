% a light on a surface is above it, or below, by rounding
%
% A lamp on the floor, a spotlight there that looks up, and a sun on the horizon do not light it.
#include "common.gml"

[ 0.3 -1.0 2.0 point white pointlight
  -2.0 -1.0 5.0 point -2.0 0.0 5.0 point white 90.0 0.0 spotlight
  1.0 0.0 0.0 point white light ] 0.25 0.25 0.25 point
white matte apply plane 30.0 rotatex 60.0 rotatex -90.0 rotatex 0.0 -1.0 0.0 translate
"floor.ppm" lit apply
