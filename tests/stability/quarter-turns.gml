% the cosine of 90 degrees is 6e-17: borders of textures flicker
%
% A scene that is turned by 90 degrees has a picture that is turned by 90 degrees.
#include "common.gml"

{ /v /u /face
  u floor v floor addi 2 modi 0 eqi { orange } { blue } if 1.0 0.0 1.0
} /tiles
tiles plane -90.0 rotatex 0.0 0.0 47.0 translate
green matte apply cube 2.0 uscale 3.0 -4.0 5.0 translate union
white matte apply cylinder 0.0 0.0 1.0 translate -1.0 2.0 6.0 translate
orange matte apply cone 30.0 rotatex -2.0 -2.0 6.0 translate union union /scene
{ /name /object object 90.0 48 48 name flat apply } /shown
scene "0.ppm" shown apply
scene 90.0 rotatez "90.ppm" shown apply
scene 90.0 rotatez 90.0 rotatez "180.ppm" shown apply
scene -45.0 rotatez -45.0 rotatez "270.ppm" shown apply
