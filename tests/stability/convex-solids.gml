% acne: a solid shadows itself
%
% Convex solids, large and small, cast no shadow on the side that is lit.
#include "common.gml"

{ /name /size /solid
  [ 1.0 -0.3 1.0 point white light 0.2 0.9 0.3 point white light
    size 5.0 mulf size 3.0 mulf size -4.0 mulf point white pointlight ] none
  solid 33.0 rotatex 21.0 rotatey 0.0 0.0 2.5 translate size uscale 0.0 0.0 -1.0 translate
  name lit apply
} /shown
{ /solid solid 1.0e10 "large.ppm" shown apply solid 1.0e-10 "small.ppm" shown apply } /twice
orange matte apply sphere twice apply
orange matte apply cube twice apply
orange matte apply cylinder twice apply
orange matte apply cone twice apply
