% of two coincident faces now the one shows, now the other
%
% A disc is let into a slab, flush with its face. The second operand of the union paints.
#include "common.gml"

orange matte apply cube -0.5 -0.5 0.0 translate 10.0 10.0 1.0 scale
30.0 rotatez 30.0 rotatez 30.0 rotatez 0.0 0.0 2.0 translate /slab
blue matte apply cylinder 90.0 rotatex 10.0 rotatez 7.0 rotatez 0.0 0.0 2.0 translate /disc
slab disc union 90.0 48 48 "disc.ppm" flat apply
disc slab union 90.0 48 48 "slab.ppm" flat apply
