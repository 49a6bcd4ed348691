% x / sqrt(1 - y^2) leaves [-1, 1] where meridians meet
%
% The eye is within a sphere and a cone, and looks at the pole and the apex. Meridians at
% multiples of 90 degrees are met exactly, and there are no others at the pole.
#include "common.gml"

[ orange blue green white ] /colors
{ /v /u /face colors u 4.0 mulf floor get 1.0 0.0 1.0 } /sectors
sectors sphere 90.0 rotatex 0.0 0.0 -1.0 translate 90.0 49 49 "pole.ppm" flat apply
sectors cone -90.0 rotatex 1.0 -1.0 1.0 scale 10.0 uscale 0.0 0.0 4.0 translate
90.0 49 49 "apex.ppm" flat apply
