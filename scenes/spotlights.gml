% spotlights.gml - red, green and blue spots cross on a stage (ICFP dialect).
%
% Everything on the stage is white: all the colour comes from the light. Where the three
% spots meet they add up to white, and a solid that takes one of them away leaves a shadow of
% the two others, yellow, cyan or magenta. Transformations move objects but never lights, so
% the stage is tilted twice: the solids with `rotatex`, the lights with `seen`, the same
% rotation written out for points.

#include "lib/surfaces.ins"

-36.0 /tilt
0.3 /rise   6.6 /away

% point seen -> point: where a place on the stage is in the world
{ /p
  tilt cos /c   tilt sin /s
  p getx
  p gety c mulf p getz s mulf subf rise addf
  p gety s mulf p getz c mulf addf away addf
  point
} /seen

% from at colour spot -> light: 18 degrees to either side, brighter in the middle
{ /colour /at /from
  from seen apply at seen apply colour 18.0 8.0 spotlight
} /spot

0.9 0.9 0.9 point matte apply /white
0.95 0.95 0.95 point 0.9 0.1 30.0 plain apply /gloss

white plane                                                     % the stage
gloss sphere 0.55 uscale 0.0 0.55 0.0 translate union
gloss cone 1.0 -1.0 1.0 scale 0.35 1.3 0.35 scale -1.25 1.3 0.35 translate union
gloss cylinder 0.26 1.1 0.26 scale 1.25 0.0 0.35 translate union
gloss cube -0.5 0.0 -0.5 translate 0.5 uscale 35.0 rotatey 0.62 0.0 -1.1 translate union
gloss sphere 0.22 uscale -0.65 0.22 -1.2 translate union
tilt rotatex 0.0 rise away translate /stage

0.05 0.05 0.07 point
[ -3.6 5.0 -2.0 point   -0.7 0.0 -0.4 point  2.1 0.16 0.1 point  spot apply
   0.0 5.0  4.0 point    0.0 0.0  0.6 point  0.1 1.8 0.18 point  spot apply
   3.6 5.0 -2.0 point    0.7 0.0 -0.4 point  0.2 0.28 2.4 point  spot apply ]
stage 1 45.0 320 240 "spotlights.ppm" render
