% a shadow ray leaves its plane more slowly than rounding moves its origin
%
% The sun stands 1e-12 above the horizon and lights all the ground.
#include "common.gml"

none [ 1.0 -1.0e-12 0.0 point 2.5e11 2.5e11 2.5e11 point light ] 1.0 0.0 0.0 point
white matte apply plane 10.0 rotatex 20.0 rotatex -30.0 rotatex 0.0 -0.7 0.0 translate 1 90.0 48 48 "ground.ppm" render
