% walls shadow themselves
%
% Eye and lamps are in rooms that are convex: no wall is in shadow.
#include "common.gml"

{ /name /room
  [ 0.1 0.2 -0.5 point white pointlight -0.3 0.4 -1.2 point white pointlight ] none
  room 0.0 0.0 -1.0 translate name lit apply
} /shown
orange matte apply sphere 1.0e10 uscale "ball.ppm" shown apply
orange matte apply cube -0.5 -0.5 -0.5 translate 7.0 rotatex 11.0 rotatey 1.0e10 uscale "cube.ppm" shown apply
orange matte apply cylinder 0.0 -0.5 0.0 translate 7.0 rotatex 1.0e10 uscale "drum.ppm" shown apply
orange matte apply cone 0.0 -0.5 0.0 translate 7.0 rotatex 1.0e10 uscale "cone.ppm" shown apply
