% dominoes.gml - a spiral of dominoes, the outer end going down (ICFP dialect).
%
% The recursion is a turtle: it carries place and heading, sets a stone, walks on, and turns
% by more the farther it has come, which makes a spiral. A fallen stone leans on the next one: the
% tilt of stone i is that of the one before, less a little, until the wave is not there yet.

#include "lib/surfaces.ins"
#include "lib/build.ins"

56 /stones
0.4 /stride

% i hue -> colour: three sines, a third of a turn apart, make a rainbow
{ /i
  i real 6.0 mulf /a
  a cos 0.42 mulf 0.5 addf
  a 120.0 subf cos 0.42 mulf 0.5 addf
  a 240.0 subf cos 0.42 mulf 0.5 addf
  point
} /hue

% i tilt -> degrees
{ real /i
  i 9.0 lessf { 62.0 i i mulf 0.62 mulf subf i subf } { 0.0 } if
} /tilt

{ /i
  i hue apply 0.8 0.2 50.0 plain apply cube
  -0.5 0.0 -0.5 translate 0.5 1.0 0.12 scale
  0.0 0.0 -0.06 translate i tilt apply rotatex 0.0 0.0 0.06 translate
} /stone

{ /go /heading /z /x /i
  i stone apply heading rotatey x 0.0 z translate
  i stones lessi
    { i 1 addi
      x heading sin stride mulf addf
      z heading cos stride mulf addf
      heading 22.9 2.7 i real 0.036 mulf subf divf addf     % stride / radius, in degrees
      go go apply union }
    { }
  if
} /row

{ /v /u /face
  u 0.08 mulf v addf 3.0 mulf /w
  w floor /plank
  plank 29 muli 11 modi real 0.02 mulf 0.75 addf w 0.97 mulf 900.0 mulf sin 0.03 mulf addf /tone
  w plank real subf 0.04 lessf { 0.45 } { tone } if /tone
  0.72 tone mulf 0.56 tone mulf 0.4 tone mulf point 0.85 0.15 40.0
} /planks

0 1.6 -2.3 242.0 row row apply
planks plane 35.0 rotatey union
-38.0 rotatex 0.0 0.0 6.4 translate /parlour

0.3 0.3 0.34 point
[ -5.0 6.0 0.0 point  1.9 1.8 1.55 point  pointlight
   5.0 4.0 -1.0 point  0.4 0.45 0.55 point  pointlight ]
parlour 2 55.0 320 240 "dominoes.ppm" render
