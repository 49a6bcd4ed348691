% a solid met with itself is full of holes
%
% A solid united or intersected with itself is that solid.
#include "common.gml"

orange matte apply cube -0.5 -0.5 -0.5 translate
blue matte apply sphere 0.6 uscale 0.2 0.3 -0.2 translate difference
green matte apply cylinder 0.3 1.7 0.4 scale 40.0 rotatez union /solid
{ 25.0 rotatex 35.0 rotatey 0.0 0.0 1.5 translate } /place
solid place apply "solid.ppm" sunny apply
solid solid union place apply "union.ppm" sunny apply
solid solid intersect place apply "intersect.ppm" sunny apply
