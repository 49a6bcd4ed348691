% what is 0.9999999999999999 for one pixel is 1 for the next
%
% All samples of a wall lie on corners of tiles. These belong to the tile above and to the
% right.
#include "common.gml"

{ /v /u /face
  u floor v floor addi 4 modi 0 eqi { orange } { blue } if 1.0 0.0 1.0
} /tiles
tiles plane -90.0 rotatex 0.0 0.0 31.0 translate 90.0 32 32 "near.ppm" flat apply
tiles plane 30.0 rotatex -60.0 rotatex -60.0 rotatex 0.0 0.0 31.0 translate
90.0 32 32 "turned.ppm" flat apply
