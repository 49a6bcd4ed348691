% a hit point is on neither side of a face that coincides with its own
%
% Nothing is left of a solid less itself.
#include "common.gml"

{ /name /solid
  solid solid difference 0.9 1.1 0.7 scale 33.0 rotatex 21.0 rotatey 0.1 0.0 2.0 translate
  60.0 48 48 name flat apply
} /less
orange matte apply sphere "sphere.ppm" less apply
orange matte apply cube "cube.ppm" less apply
orange matte apply cylinder "cylinder.ppm" less apply
orange matte apply cone "cone.ppm" less apply
orange matte apply cube blue matte apply sphere 0.7 uscale difference "compound.ppm" less apply
