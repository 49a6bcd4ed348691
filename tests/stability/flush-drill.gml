% a drill as long as the plate is thick leaves a skin, here and there
%
% A drill that ends where the plate ends opens the same hole as a longer one.
#include "common.gml"

orange matte apply cube -0.5 0.0 -0.5 translate 2.0 0.3 2.0 scale /plate
blue matte apply cylinder 0.6 1.0 0.6 scale /drill
{ -70.0 rotatex 20.0 rotatey 0.1 -0.1 1.3 translate } /place
plate drill 0.0 -0.5 0.0 translate 1.0 3.0 1.0 scale difference place apply "long.ppm" sunny apply
plate drill 1.0 0.3 1.0 scale difference place apply "flush.ppm" sunny apply
plate drill 1.0 -1.0 1.0 scale 0.0 1.0 0.0 translate 1.0 0.3 1.0 scale difference place apply
"mirrored.ppm" sunny apply
