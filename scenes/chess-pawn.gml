% chess-pawn.gml - pawns and a bishop on a corner of the board (ICFP dialect).
%
% Turned pieces: frustums (cones cut off by half-spaces), collars (flattened spheres) and balls
% on one axis. A piece is a function from surface to object, so one description serves both
% sides. The cleft of the bishop's mitre is a thin tilted box, taken away.

#include "lib/surfaces.ins"
#include "lib/build.ins"

% surface radius height disc -> object: a flat round cushion, its middle at that height
{ /height /radius /surface
  surface sphere radius radius 0.3 mulf radius scale 0.0 height 0.0 translate
} /disc

% surface foot -> object: what all pieces stand on
{ /surface
  surface cylinder 0.42 0.1 0.42 scale
  surface 0.4 0.12 disc apply union
  surface 0.32 0.24 disc apply union
} /foot

{ /surface
  surface foot apply
  surface 0.27 0.13 0.62 frustum apply apply 0.0 0.24 0.0 translate union
  surface 0.24 0.86 disc apply union
  surface sphere 0.22 uscale 0.0 1.07 0.0 translate union
} /pawn

{ /surface
  surface foot apply
  surface 0.3 0.12 0.9 frustum apply apply 0.0 0.24 0.0 translate union
  surface 0.27 1.1 disc apply union
  surface 0.19 1.2 disc apply union
  surface sphere 0.21 0.33 0.21 scale 0.0 1.5 0.0 translate
  surface cube -0.5 -0.5 -1.0 translate 0.6 0.07 0.6 scale       % the cleft, to the front
    48.0 rotatex 0.0 1.45 0.0 translate difference
  union
  surface sphere 0.075 uscale 0.0 1.86 0.0 translate union
} /bishop

% dark pale wood -> surface: rings of growth, stretched along v
{ /pale /dark
  { /v /u /face
    u 7.0 mulf v 40.0 mulf sin 0.5 mulf addf 360.0 mulf sin
    u 23.0 mulf 360.0 mulf sin 0.4 mulf addf 0.3 mulf 0.5 addf clampf /t
    1.0 t subf /s
    dark getx s mulf pale getx t mulf addf
    dark gety s mulf pale gety t mulf addf
    dark getz s mulf pale getz t mulf addf point
    0.8 0.2 40.0
  }
} /wood

0.16 0.07 0.03 point 0.24 0.11 0.05 point wood apply /walnut
0.72 0.5 0.28 point 0.84 0.64 0.4 point wood apply /maple
0.95 0.78 0.52 point 0.85 0.15 50.0 plain apply /boxwood
0.34 0.13 0.09 point 0.75 0.25 60.0 plain apply /ebony

% The squares are thin boxes, each with its own grain: the array of surfaces is indexed by
% the colour of the square
[ walnut maple ] /woods
64 { /i
  i 8 modi /column
  i 8 divi /row
  woods column row addi 2 modi get cube
  1.0 0.1 1.0 scale column real 4.0 subf -0.1 row real 4.0 subf translate
} repeat apply /board

% object column row at -> object: on the middle of a square
{ /row /column
  column real 3.5 subf 0.0 row real 3.5 subf translate
} /at

board
walnut cube 8.6 0.3 8.6 scale -4.3 -0.32 -4.3 translate union
boxwood pawn apply 3 1 at apply union
boxwood bishop apply -65.0 rotatey 2 2 at apply union
boxwood pawn apply 1 3 at apply union
ebony pawn apply 4 2 at apply union
ebony bishop apply 62.0 rotatey 4 4 at apply union
ebony pawn apply 2 5 at apply union
ebony pawn apply 5 3 at apply union
24.0 rotatey -26.0 rotatex 0.7 -0.2 5.6 translate /game

0.3 0.3 0.34 point
[ -3.5 6.0 0.5 point  1.9 1.75 1.45 point  pointlight
   5.0 4.0 2.0 point  0.7 0.75 0.95 point  pointlight ]
game 2 45.0 320 240 "chess-pawn.ppm" render
