% lamp.gml - a lamp in a perforated shell throws dots on the walls (ICFP dialect).
%
% The shell is a ball less a smaller ball less 76 rods that leave its middle in all directions.
% The light is a point in the middle: it is not seen itself, but the inside of the shell, which
% has the surface of the smaller ball, is brightly lit through the holes, and what passes them
% paints the room. The rods are listed as rings: how far from the pole, how many to the ring.

#include "lib/surfaces.ins"
#include "lib/build.ins"

0.95 0.62 0.25 point 0.55 0.45 60.0 plain apply /brass
1.0 0.95 0.8 point matte apply /enamel
0.9 0.86 0.8 point matte apply /plaster
0.85 0.42 0.3 point 0.9 0.1 20.0 plain apply /clay

[ [ 24.0 6 ] [ 46.0 10 ] [ 67.0 14 ] [ 90.0 16 ] [ 113.0 14 ] [ 134.0 10 ] [ 156.0 6 ] ] /rings

{ /ring
  ring 0 get /polar
  ring 1 get /count
  count { /i
    brass cylinder 0.062 1.0 0.062 scale polar negf rotatez
    i real 0.5 addf 360.0 mulf count real divf rotatey
  } repeat apply
} /bore

brass sphere 0.5 uscale
enamel sphere 0.46 uscale
rings bore unite apply union difference
brass cylinder 0.018 3.0 0.018 scale 0.0 0.48 0.0 translate union
brass sphere 0.09 0.06 0.09 scale 0.0 0.51 0.0 translate union
12.0 rotatey 0.0 0.25 3.0 translate /lantern

% The room: a box less a box
plaster cube -0.5 -0.5 -0.5 translate 9.0 uscale 0.0 0.0 2.0 translate
plaster cube -0.5 0.0 -0.5 translate 4.6 3.2 6.0 scale 0.0 -1.3 2.0 translate
difference
lantern union
clay sphere 0.34 uscale -1.15 -0.96 2.9 translate union
clay cylinder 0.3 0.75 0.3 scale 1.5 -1.3 3.3 translate union
clay cube -0.5 0.0 -0.5 translate 0.5 uscale 30.0 rotatey 0.62 -1.3 2.5 translate union
/room

0.12 0.11 0.13 point
[ 0.0 0.25 3.0 point  1.3 1.0 0.62 point  pointlight
  1.2 1.0 -0.7 point  0.4 0.45 0.6 point  pointlight ]
room 2 70.0 320 240 "lamp.ppm" render
