% marble.gml - a marble ball on a marble floor (ICFP dialect).
%
% The stone is a function of the place in space: veins are the zeros of a sine whose phase is
% disturbed by sines of growing frequency and shrinking size, each bent by the one before.
% The ball first turns its u and v back into a place, so that the veins run through the solid
% and have no seam. About sixty operations a point, hundred thousand points: this scene is
% about how fast surface functions are.

#include "lib/surfaces.ins"

% x y z turbulence -> real: four octaves of sines
{ /z /y /x
  x 97.0 mulf z 61.0 mulf 30.0 addf sin 80.0 mulf addf sin /a
  y 173.0 mulf a 95.0 mulf addf x 41.0 mulf addf sin /b
  z 311.0 mulf b 110.0 mulf addf y 67.0 mulf subf sin /c
  x 617.0 mulf c 85.0 mulf addf z 283.0 mulf addf sin /d
  a b 0.55 mulf addf c 0.3 mulf addf d 0.16 mulf addf
} /turbulence

% base vein x y z stone -> colour: thin bright veins, a broad cloud of shade
{ /z /y /x /vein /base
  x y z turbulence apply /t
  x y addf z 0.6 mulf addf 100.0 mulf t 130.0 mulf addf sin /wave
  1.0 wave wave mulf sqrt subf /near                     % 1 on the vein
  near near mulf near mulf near mulf /sharp
  0.8 t 0.14 mulf addf 1.0 sharp subf mulf /rest
  base getx rest mulf vein getx sharp mulf addf clampf
  base gety rest mulf vein gety sharp mulf addf clampf
  base getz rest mulf vein getz sharp mulf addf clampf
  point
} /stone

0.08 0.3 0.24 point /malachite   0.93 0.85 0.6 point /cream
0.92 0.88 0.84 point /carrara    0.3 0.32 0.38 point /grey
0.32 0.06 0.07 point /rosso      0.75 0.52 0.48 point /pale

% base vein size ball-of -> surface: stone in the shape of a sphere
{ /size /vein /base
  { /v /u /face
    v 2.0 mulf 1.0 subf /y
    1.0 y y mulf subf sqrt size mulf /r
    u 360.0 mulf /turn
    base vein turn sin r mulf y size mulf turn cos r mulf stone apply
    0.75 0.25 70.0
  }
} /ball-of

% Tiles of two stones, each tile cut from another place of the quarry
{ /v /u /face
  u floor /i   v floor /j
  i real 7.3 mulf /shift
  i j addi 2 modi 0 eqi
    { carrara grey u shift j real 3.1 mulf addf v stone apply }
    { rosso pale v shift j real 2.3 mulf addf u stone apply }
  if
  u i real subf 0.5 subf /du
  v j real subf 0.5 subf /dv
  du du mulf 0.2304 lessf { dv dv mulf 0.2304 lessf } { false } if   % |du|, |dv| < 0.48
    { 0.8 0.2 50.0 }
    { 0.25 0.0 1.0 }                                                  % the joint
  if
} /tiles

malachite cream 1.2 ball-of apply sphere 40.0 rotatey -0.45 0.0 0.0 translate
rosso pale 0.9 ball-of apply sphere 0.5 uscale 1.25 -0.5 -0.75 translate union
carrara grey 0.9 ball-of apply sphere 0.38 uscale 0.45 -0.62 -1.45 translate union
tiles plane 1.4 uscale 0.6 -1.0 0.3 translate 25.0 rotatey union
-29.0 rotatex -0.15 0.15 4.0 translate /room

0.32 0.32 0.36 point
[ -4.0 5.0 -1.0 point  1.9 1.8 1.6 point  pointlight
   3.0 3.0 -2.0 point  0.35 0.4 0.5 point  pointlight ]
room 2 48.0 320 240 "marble.ppm" render
