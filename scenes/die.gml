% die.gml - three dice on green felt (ICFP dialect).
%
% A die is a cube cut to a rounder shape by a sphere, less 21 small spheres. The pips have the
% colour of the spheres, for the surface of a hole is that of the solid that was taken away.
% The trickiest part: pips are written down once, for the face towards the viewer, and turned
% from there to the other five.

#include "lib/surfaces.ins"
#include "lib/build.ins"

% Where the pips are on a face, in units of the distance from the middle
-1.0 -1.0 0.0 point /sw   -1.0 1.0 0.0 point /nw   -1.0 0.0 0.0 point /w
 1.0 -1.0 0.0 point /se    1.0 1.0 0.0 point /ne    1.0 0.0 0.0 point /e
 0.0  0.0 0.0 point /mid

[ [ mid ]
  [ sw ne ]
  [ sw mid ne ]
  [ sw nw se ne ]
  [ sw nw mid se ne ]
  [ sw nw w se ne e ]
] /patterns

% number surface face -> object: the pips of a number, on the face z = -1
{ /surface /number
  patterns number 1 subi get
  { /at
    surface sphere 0.22 uscale
    at getx 0.5 mulf at gety 0.5 mulf -1.08 translate
  } unite apply
} /face-pips

% body-surface pip-surface die -> object: twice as wide as high is the cube, -1 to 1
{ /ink /body
  { ink face-pips apply } /pips
  body cube -0.5 -0.5 -0.5 translate 2.0 uscale
  body sphere 1.43 uscale intersect
  1 pips apply
  6 pips apply 180.0 rotatey union
  2 pips apply 90.0 rotatex union              % up
  5 pips apply -90.0 rotatex union             % down
  3 pips apply 90.0 rotatey union              % left
  4 pips apply -90.0 rotatey union             % right
  difference
} /die

0.93 0.9 0.8 point 0.75 0.25 40.0 plain apply /ivory
0.8 0.06 0.05 point 0.7 0.35 50.0 plain apply /ruby
0.08 0.07 0.07 point matte apply /ink
1.0 0.97 0.9 point matte apply /chalk

% Felt: two waves across each other make a weave
{ /v /u /face
  u 1500.0 mulf sin v 1500.0 mulf sin mulf 0.06 mulf 0.94 addf /weave
  0.06 weave mulf 0.36 weave mulf 0.2 weave mulf point 1.0 0.0 1.0
} /felt

ivory ink die apply 32.0 rotatey -0.95 0.0 0.4 translate
ruby chalk die apply 90.0 rotatex -25.0 rotatey 1.35 0.0 -0.5 translate union
ivory ink die apply 180.0 rotatez 12.0 rotatey 0.45 0.0 3.6 translate union
felt plane 0.0 -1.0 0.0 translate union
-32.0 rotatex -0.15 0.1 6.0 translate /table      % seen from above

0.26 0.26 0.3 point
[ -4.0 7.0 0.0 point  1.9 1.75 1.5 point  pointlight
   6.0 4.0 -1.0 point  0.45 0.5 0.7 point  pointlight ]
table 2 48.0 320 240 "die.ppm" render
