% u = 1, or a hair below 0, is outside of the table of colours
%
% The eye is within a sphere, a cylinder and a cone, and looks at the seam, where u goes from 1
% to 0. The seam itself has u = 0.
#include "common.gml"

[ orange orange orange orange blue blue blue blue ] /colors
{ /v /u /face colors u 8.0 mulf floor get 1.0 0.0 1.0 } /bands
{ /name /object
  object 40.0 rotatey 80.0 rotatey -120.0 rotatey 0.0 0.0 -1.0 translate
  90.0 49 49 name flat apply
} /around
bands sphere 3.0 uscale "sphere.ppm" around apply
bands cylinder 0.0 -0.5 0.0 translate 1.0 1000.0 1.0 scale "cylinder.ppm" around apply
bands cone 0.0 -0.5 0.0 translate 1.0 1000.0 1.0 scale "cone.ppm" around apply
