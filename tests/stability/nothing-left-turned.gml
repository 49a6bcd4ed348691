% transforms that differ by a rounding leave slivers of a solid less itself
%
% Nothing is left of a solid less itself, turned or mirrored so that it comes to lie on itself.
#include "common.gml"

{ /name /other /solid
  solid other difference 33.0 rotatex 21.0 rotatey 0.1 0.0 2.0 translate 60.0 48 48 name flat apply
} /less
orange matte apply cone /funnel
funnel funnel 12.0 rotatey 24.0 rotatey 5.0 rotatey "cone.ppm" less apply
orange matte apply sphere /sphere0
sphere0 sphere0 17.0 rotatex 29.0 rotatey 41.0 rotatez "sphere.ppm" less apply
orange matte apply cylinder 0.0 -0.5 0.0 translate /cylinder0
cylinder0 cylinder0 1.0 -1.0 1.0 scale 60.0 rotatex 120.0 rotatex "cylinder.ppm" less apply
orange matte apply cube -0.5 -0.5 -0.5 translate /cube0
cube0 cube0 45.0 rotatez 45.0 rotatez 30.0 rotatex 60.0 rotatex "cube.ppm" less apply
