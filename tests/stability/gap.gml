% surfaces nearer to one another than the epsilon are jumped over
%
% The eye is in a gap of 2e-8 below a ceiling that keeps all light off the floor.
% The middle row looks along both, and meets neither.
#include "common.gml"

[ 0.3 5.0 0.2 point white pointlight 0.1 -1.0 0.2 point white light ] 0.5 0.5 0.5 point
white matte apply plane 0.0 -1.0e-8 0.0 translate
white matte apply plane 180.0 rotatex 0.0 1.0e-8 0.0 translate union
"gap.ppm" lit apply
