% kaleidoscope.gml - beads at the end of a tube of three mirrors (ICFP dialect).
%
% Three half-spaces turned by 120 degrees leave a triangular tube, and the eye is in it. Each
% reflection leads to the next wall, so what looks like a lattice of triangles is one triangle
% seen by rays of up to thirty bounces. At a reflection of 95 % the thirtieth still has a
% fifth of the light. In the ICFP dialect the colour of the glass tints every bounce.

#include "lib/surfaces.ins"
#include "lib/build.ins"

0.98 1.0 0.99 point 0.0 0.95 5000.0 plain apply /glass

% The end of the tube: a disc of opal light, coloured in rays and rings
{ /v /u /face
  u u mulf v v mulf addf sqrt /r
  u 400.0 mulf sin v 330.0 mulf 50.0 addf sin addf 0.25 mulf 0.5 addf /a
  r 900.0 mulf 40.0 addf sin 0.5 mulf 0.5 addf /b
  0.75 a mulf 0.2 b mulf addf 0.08 addf
  0.22 b mulf 0.3 a a mulf mulf addf 0.06 addf
  0.55 1.0 a subf mulf 0.15 b mulf addf 0.12 addf
  point 1.15 0.0 1.0
} /opal

% Beads: x, y and radius as a point, in the order of the colours below
[ 0.0 0.05 0.24 point    0.42 -0.28 0.2 point   -0.35 -0.36 0.15 point
  0.02 0.56 0.16 point  -0.55 -0.1 0.12 point   0.3 0.2 0.12 point
  0.02 -0.4 0.11 point  -0.25 0.28 0.13 point ] /beads

[ 1.0 0.75 0.1 point   0.9 0.1 0.2 point   0.1 0.65 0.85 point   0.95 0.3 0.7 point
  0.3 0.85 0.3 point   1.0 1.0 0.95 point  1.0 0.5 0.1 point     0.4 0.25 0.9 point ] /dyes

{ /i
  beads i get /bead
  dyes i get 0.85 0.15 50.0 plain apply sphere
  bead getz uscale bead getx bead gety 3.0 translate
} /place

3 { real 120.0 mulf /turn
    glass plane 0.0 -0.62 0.0 translate turn rotatez
} repeat apply
beads length place repeat apply union
opal plane -90.0 rotatex 0.0 0.0 3.3 translate union
9.0 rotatez /tube

0.5 0.5 0.5 point
[ 0.1 0.15 -0.4 point  0.85 0.83 0.8 point  pointlight ]
tube 30 75.0 320 240 "kaleidoscope.ppm" render
