% helix-stairs.gml - a winding stair around a column, up into the evening (Chicago dialect).
%
% A recursion walks up the stair. Step i is the same step, turned by 18 degrees times i and
% lifted by 0.145 times i; a post with a ball stands on its outer end, and its colour is a
% function of i too. The rail is a second, finer recursion: a string of beads.

#include "lib/surfaces.ins"
#include "lib/build.ins"

34 /steps
18.0 /turn
0.145 /rise

% i hue -> colour: from red at the foot through violet to blue
{ /i
  i real steps real divf /t
  t 90.0 mulf cos 0.85 mulf 0.1 addf
  t 180.0 mulf sin 0.28 mulf 0.22 addf
  t 90.0 mulf sin 0.65 mulf 0.2 addf
  point
} /hue

0.92 0.9 0.86 point 0.9 0.1 30.0 plain apply /stone
1.0 0.76 0.36 point 0.7 0.3 60.0 plain apply /brass
0.35 0.42 0.55 point 0.35 0.5 30.0 plain apply /lake

{ /i
  i hue apply 0.85 0.15 40.0 plain apply cube
    -0.5 0.0 0.0 translate 0.52 0.07 1.5 scale 0.0 0.0 0.3 translate
  brass cylinder 0.022 0.62 0.022 scale 0.0 0.07 1.68 translate union
  i real turn mulf rotatey
  0.0 i real rise mulf 0.0 translate
} /step

3 /fine                                         % beads to a step
{ /i
  i real fine real divf /at
  brass sphere 0.055 uscale 0.0 0.72 1.68 translate
  at turn mulf rotatey 0.0 at rise mulf 0.0 translate
} /bead

{ /v /u /face
  v 2.0 mulf 1.0 subf clampf /h
  1.0 h subf /low
  low low mulf low mulf low mulf /glow
  0.08 glow 0.9 mulf addf  0.13 low 0.2 mulf addf glow 0.3 mulf addf  0.3 low 0.25 mulf addf
  point 1.5 0.0 1.0
} /sky

steps step repeat apply
steps 1 subi fine muli bead repeat apply union
stone cylinder 0.3 5.5 0.3 scale union
brass sphere 0.42 uscale 0.0 5.85 0.0 translate union
stone sphere 0.55 0.12 0.55 scale union
0.6 0.56 0.54 point 0.22 0.2 0.24 point 0.15 checker apply plane 0.5 uscale
  stone cylinder 3.2 1.0 3.2 scale 0.0 -0.9 0.0 translate intersect union   % a round terrace
lake plane 0.0 -0.5 0.0 translate union
110.0 rotatey -5.0 rotatex 0.0 -2.75 8.6 translate
sky 150.0 dome apply union /tower

0.45 0.45 0.5 point
[ -6.0 5.0 -3.0 point  1.5 1.3 1.05 point  pointlight
   5.0 2.0 1.0 point  0.35 0.4 0.6 point  pointlight ]
1.0 0.0 0.006 point
tower 3 52.0 320 240 "helix-stairs.ppm" render
