% chains of set operations depend on their order
%
% A plate with a hundred flush holes, drilled one by one in the order of rows, in the other
% order, and all at once.
#include "common.gml"

orange matte apply cube 1.0 0.1 1.0 scale /plate
{ /k orange matte apply cylinder 0.4 1.0 0.4 scale 10.0 rotatey 0.1 uscale
  k 10 modi real 0.1 mulf 0.05 addf 0.0 k 10 divi real 0.1 mulf 0.05 addf translate } /hole
{ /self /n /rest n 0 eqi { rest } { rest n 1 subi hole apply difference n 1 subi self self apply } if } /down
{ /self /n /rest n 0 eqi { rest } { rest 100 n subi hole apply difference n 1 subi self self apply } if } /up
{ /self /n /rest n 0 eqi { rest } { rest n 1 subi hole apply union n 1 subi self self apply } if } /all
{ /name /object
  object -0.5 0.0 -0.5 translate -70.0 rotatex 15.0 rotatez 0.0 0.0 0.3 translate name sunny apply
} /shown
plate 100 down down apply "down.ppm" shown apply
plate 100 up up apply "up.ppm" shown apply
plate 0 hole apply 100 all all apply difference "all.ppm" shown apply
