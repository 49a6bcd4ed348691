% showpiece.gml - a round temple on an island, lit from within, at nightfall (Chicago dialect).
%
% Ten columns carry a ring and a dome on three steps; stepping stones lead there over still
% water, paper lanterns float on it. Three things to note: the lamp under the dome makes the
% columns throw long shadows and fades with distance (attn). Sky, stars and moon are one
% surface function on the inside of a ball. And since a surface function can set the
% reflected share from place to place, waves that no geometry knows of ripple the water.

#include "lib/surfaces.ins"
#include "lib/build.ins"

% The camera looks straight ahead, so the world is tilted to look up a little. Transformations
% do not move lights: `seen` does to a point what `tilted` does to an object.
3.2 /tilt   -1.4 /drop

{ tilt rotatex 0.0 drop 0.0 translate } /tilted
{ /p
  tilt cos /c   tilt sin /s
  p getx
  p gety c mulf p getz s mulf subf drop addf
  p gety s mulf p getz c mulf addf
  point
} /seen

% --- Surfaces ---------------------------------------------------------------------------------

0.86 0.82 0.76 point 0.92 0.08 20.0 plain apply /marble
0.6 0.57 0.54 point matte apply /granite
1.0 0.74 0.3 point 0.55 0.45 60.0 plain apply /gold

% The dome: copper gone green, in 24 ribs
{ /v /u /face
  u 24.0 mulf frac 0.5 subf /rib
  rib rib mulf 2.2 mulf 0.5 addf /tone
  0.3 tone mulf 0.62 tone mulf 0.55 tone mulf point 0.9 0.1 20.0
} /copper

{ /v /u /face
  u 8000.0 mulf v 5000.0 mulf sin 90.0 mulf addf sin 0.2 mulf 0.8 addf /tone
  0.05 tone mulf 0.13 tone mulf 0.07 tone mulf point 1.0 0.0 1.0
} /leaves

% Water: long low waves, which flatten out in the distance
{ /v /u /face
  v 420.0 mulf u 75.0 mulf sin 120.0 mulf addf u 31.0 mulf addf sin
  v 990.0 mulf u 160.0 mulf sin 70.0 mulf addf u 210.0 mulf subf sin 0.6 mulf addf
  1.0 v v mulf 0.02 mulf addf divf /wave
  0.03 0.06 0.09 point 0.4 0.66 wave 0.13 mulf addf 200.0
} /water

% x hash -> real: between 0 and 1, and never mind how
{ 12.9898 mulf sin 43758.547 mulf frac 0.5 mulf 0.5 addf } /hash

% Sky: u turns around the horizon (0 is straight ahead), v is the height
{ /v /u /face
  v 2.0 mulf 1.0 subf clampf /h
  1.0 h subf /low
  low low mulf low mulf low mulf low mulf /dusk                 % a band at the horizon
  u 360.0 mulf 28.0 addf cos 0.5 mulf 0.5 addf /west
  dusk west west mulf mulf /glow                                % where the sun has gone

  h 2600.0 mulf u 1440.0 mulf sin 140.0 mulf addf u 3600.0 mulf addf sin 0.5 mulf 0.5 addf
  u 2160.0 mulf h 900.0 mulf addf sin 0.5 mulf 0.5 addf mulf
  low mulf glow 0.04 addf mulf 0.75 mulf /cloud

  u 260.0 mulf /a   v 180.0 mulf /b
  a floor real 61.0 mulf b floor real addf hash apply /luck
  0.965 luck lessf
    { a frac 0.2 subf luck 3000.0 mulf frac 0.6 mulf subf /da   % somewhere in its cell
      b frac 0.3 subf luck 7000.0 mulf frac 0.4 mulf subf /db
      da da mulf db db mulf 0.2 mulf addf 0.02 lessf
        { luck 0.965 subf 28.0 mulf h 2.5 mulf clampf mulf } { 0.0 } if }
    { 0.0 }
  if /star

  u 0.047 subf 0.0028 divf /dx   h 0.262 subf 0.0165 divf /dy   % the moon, a disc less a disc
  dx dx mulf dy dy mulf addf 1.0 lessf
    { dx 0.5 subf /ex   dy 0.4 subf /ey   1.0 ex ex mulf ey ey mulf addf lessf }
    { false }
  if { 1.0 } { star } if /star

  0.03 glow 1.1 mulf addf dusk 0.1 mulf addf cloud 0.55 mulf subf star addf
  0.05 glow 0.48 mulf addf dusk 0.1 mulf addf cloud 0.42 mulf subf star addf
  0.15 glow 0.16 mulf addf dusk 0.2 mulf addf cloud 0.1 mulf subf star addf
  point 3.4 0.0 1.0
} /sky

% --- The temple -------------------------------------------------------------------------------

% surface outer inner height ring -> object
{ /height /inner /outer /surface
  surface cylinder outer height outer scale
  surface cylinder inner height 2.0 mulf inner scale 0.0 height -0.5 mulf 0.0 translate
  difference
} /ring

marble cylinder 0.24 0.1 0.24 scale
marble 0.17 0.135 2.0 frustum apply apply 0.0 0.1 0.0 translate union
marble sphere 0.19 0.06 0.19 scale 0.0 2.1 0.0 translate union
marble cube -0.5 0.0 -0.5 translate 0.42 0.1 0.42 scale 0.0 2.13 0.0 translate union
/column

10 { /i
  column 0.0 0.0 -1.7 translate i real 36.0 mulf 18.0 addf rotatey
} repeat apply
marble 1.95 1.45 0.3 ring apply 0.0 2.23 0.0 translate union
marble 2.08 1.45 0.09 ring apply 0.0 2.53 0.0 translate union
copper sphere 1.72 uscale
  marble sphere 1.62 uscale difference
  marble plane 180.0 rotatex intersect                          % the half with y > 0
  1.0 0.92 1.0 scale 0.0 2.62 0.0 translate union
gold sphere 0.14 uscale 0.0 4.28 0.0 translate union
gold cone 0.05 -0.5 0.05 scale 0.0 4.85 0.0 translate union
marble cylinder 0.3 0.7 0.3 scale union                         % within: an altar and a ball
gold sphere 0.3 uscale 0.0 0.98 0.0 translate union
0.0 0.54 0.0 translate
3 { real /i
  granite cylinder 2.15 i 0.28 mulf addf 0.54 i 0.18 mulf subf 2.15 i 0.28 mulf addf scale
} repeat apply union
granite sphere 3.05 0.16 3.0 scale union                         % the island
0.0 0.0 10.5 translate /temple

% --- What is around it ------------------------------------------------------------------------

% Stepping stones swing from the viewer to the stairs
9 { real /i
  granite cylinder 0.36 0.16 0.36 scale
  i 40.0 mulf sin 0.55 mulf 0.0 0.85 i 0.72 mulf addf translate
} repeat apply /path

% A cypress: two spindles
{ /height
  leaves sphere 0.3 height 0.5 mulf 0.3 scale 0.0 height 0.5 mulf 0.0 translate
  leaves sphere 0.36 height 0.3 mulf 0.36 scale 0.0 height 0.36 mulf 0.0 translate union
} /cypress

2.9 cypress apply -2.75 0.0 10.6 translate
2.3 cypress apply -3.1 0.0 9.4 translate union
3.2 cypress apply 2.8 0.0 10.9 translate union
2.5 cypress apply 3.2 0.0 9.9 translate union /trees

% Far hills: x, z and height as points
[ -46.0 80.0 6.0 point  -18.0 92.0 4.0 point  30.0 85.0 5.0 point  58.0 78.0 8.0 point ]
{ /at
  0.26 0.18 0.36 point matte apply sphere 24.0 at getz 12.0 scale
  at getx 0.0 at gety translate
} unite apply /hills

% Lanterns: x, z and size as points
[ -1.7 2.6 0.12 point  -2.6 5.4 0.13 point   2.7 5.2 0.12 point
  -3.9 8.2 0.13 point   3.9 7.6 0.13 point  -4.6 6.2 0.12 point
   1.9 6.6 0.11 point   4.9 9.9 0.13 point  -1.5 6.7 0.1 point ]
{ /at
  { /v /u /face  3.4 1.3 v 0.7 mulf addf 0.35 point 1.0 0.0 1.0 } sphere
  at getz at getz 1.25 mulf at getz scale at getx at getz at gety translate
} unite apply /lanterns

temple path union trees union hills union lanterns union
water plane union
sky 260.0 dome apply union
tilted apply /scene

0.27 0.28 0.36 point
[ 0.0 2.55 10.5 point seen apply  2.6 1.75 0.95 point  pointlight
  -16.0 13.0 -4.0 point seen apply  9.0 10.5 15.0 point  pointlight ]
1.0 0.05 0.05 point
scene 4 53.0 480 320 "showpiece.ppm" render
