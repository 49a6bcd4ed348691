% flake.gml - a sphere flake: nine balls on a ball, nine on each of those ... (ICFP dialect).
%
% A flake of level n is a sphere and nine flakes of level n - 1, a third as large: six around
% the waist, three above. Objects are values: the smaller flake is made once, moved to the
% pole, and the nine are rotated copies of that. So the recursion is one call a level, and
% four levels give 1 + 9 + 81 + 729 = 820 spheres.

#include "lib/surfaces.ins"
#include "lib/build.ins"

% By level: the one ball of level 3 reflects the most
[ 0.95 0.9 0.85 point 0.5 0.5 60.0 plain apply
  1.0 0.45 0.3 point 0.6 0.4 60.0 plain apply
  1.0 0.72 0.25 point 0.5 0.5 80.0 plain apply
  0.62 0.74 0.95 point 0.35 0.65 100.0 plain apply ] /metals

{ /self /level
  metals level get sphere
  level 0 eqi
    { }
    { level 1 subi self self apply 0.333333 uscale 0.0 1.333333 0.0 translate /bud
      6 { real 60.0 mulf /turn  bud -90.0 rotatez turn rotatey } repeat apply union
      3 { real 120.0 mulf 30.0 addf /turn  bud -36.0 rotatez turn rotatey } repeat apply union
    }
  if
} /flake

% A dusk over a dark lake; the colours are above 1 where the sky glows
{ /v /u /face
  v 2.0 mulf 1.0 subf clampf /h
  1.0 h subf /low
  low low mulf low mulf low mulf /glow
  0.1 glow 1.0 mulf addf   0.14 low 0.25 mulf addf glow 0.25 mulf addf   0.32 low 0.2 mulf addf
  point 1.6 0.0 1.0
} /sky

0.5 0.55 0.65 point 0.35 0.65 40.0 plain apply /lake

3 flake flake apply 14.0 rotatey -18.0 rotatex 0.0 -0.05 4.6 translate
lake plane 0.0 -1.7 0.0 translate union
sky 200.0 dome apply union /scene

0.42 0.42 0.46 point
[ -6.0 7.0 -6.0 point  3.0 2.7 2.3 point  pointlight ]
scene 3 50.0 320 240 "flake.ppm" render
