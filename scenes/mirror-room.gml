% mirror-room.gml - a pedestal in a room whose four walls are framed mirrors (Chicago).
%
% The room is one cube less another, and the eye is in the hole, which has the surface of the
% cube that was taken away. It tells the walls by `face`, and on a wall the frame from the
% glass by u and v. In the Chicago dialect a mirror is not tinted by its colour, so black
% glass reflects best. The depth counts the first ray too: twelve is eleven reflections.

#include "lib/surfaces.ins"

% x edge edged -> bool: is x, from 0 to 1, closer than that to either end
{ /edge /x
  x edge lessf { true } { 1.0 edge subf x lessf } if
} /edged

0.45 0.24 0.1 point /oak

% The walls: a frame of oak, and glass in three bays
{ /v /u /face
  u 3.0 mulf frac /bay
  v 0.06 edged apply { true } { bay 0.04 edged apply } if
    { oak 0.85 0.15 20.0 }
    { 0.0 0.0 0.0 point 0.0 0.86 300.0 }
  if
} /wall

% Floor boards, each a little different, and a ceiling with a round skylight
{ /v /u /face
  u 14.0 mulf floor /board
  v 3.0 mulf board real 0.37 mulf addf floor /piece
  board 37 muli piece 59 muli addi 13 modi real 0.025 mulf 0.72 addf /tone
  0.62 tone mulf 0.4 tone mulf 0.22 tone mulf point 0.85 0.15 30.0
} /boards

{ /v /u /face
  u 0.5 subf /x   v 0.5 subf /z
  x x mulf z z mulf addf 0.012 lessf
    { 1.3 1.35 1.5 point 2.0 0.0 1.0 }
    { 0.85 0.83 0.8 point 0.9 0.0 1.0 }
  if
} /ceiling

% The surface of the room hands its arguments on to that of the face
[ wall wall wall wall ceiling boards ] /sides
{ /v /u /face
  face u v sides face get apply
} /room

0.75 0.72 0.68 point matte apply /plaster
1.0 0.6 0.15 point 0.55 0.4 60.0 plain apply /gold
0.75 0.08 0.1 point 0.8 0.15 40.0 plain apply /red
0.08 0.35 0.6 point 0.8 0.15 40.0 plain apply /blue
0.1 0.5 0.25 point 0.8 0.15 40.0 plain apply /green

0.0 0.0 0.0 point matte apply cube -0.5 -0.5 -0.5 translate 10.0 uscale
room cube -0.5 0.0 -0.5 translate 7.4 3.6 7.4 scale difference
plaster cylinder 0.42 1.0 0.42 scale union
plaster cylinder 0.55 0.12 0.55 scale union
plaster cylinder 0.52 0.1 0.52 scale 0.0 0.95 0.0 translate union
gold sphere 0.42 uscale 0.0 1.46 0.0 translate union
red sphere 0.35 uscale -1.3 0.35 -0.5 translate union
blue cone 1.0 -1.0 1.0 scale 0.0 1.0 0.0 translate 0.4 1.0 0.4 scale
  1.2 0.0 0.3 translate union
green cube -0.5 0.0 -0.5 translate 0.6 uscale 20.0 rotatey -0.6 0.0 1.5 translate union
28.0 rotatey -9.0 rotatex 0.3 -1.6 2.3 translate /scene

0.38 0.38 0.4 point
[ 0.3 1.6 1.8 point  0.95 0.9 0.85 point  pointlight
  1.5 1.2 -0.5 point  0.4 0.4 0.45 point  pointlight ]
1.0 0.0 0.03 point
scene 12 78.0 320 240 "mirror-room.ppm" render
