% A closed room of mirrors around a mirrored sphere. Each point that a path meets adds a thousandth of
% its colour, which says where on its surface it is.
{ /v /u /face u 8.0 divf 0.5 addf v 8.0 divf 0.5 addf 0.5 point 0.001 1.0 1.0 } /wall
{ /v /u /face u v 0.5 point 0.001 1.0 1.0 } /ball
wall plane 0.0 -2.0 0.0 translate
wall plane 180.0 rotatez 0.0 2.0 0.0 translate union
wall plane -90.0 rotatez -2.0 0.0 0.0 translate union
wall plane  90.0 rotatez  2.0 0.0 0.0 translate union
wall plane -90.0 rotatex 0.0 0.0 2.1 translate union
wall plane  90.0 rotatex 0.0 0.0 -1.9 translate union
ball sphere 1.1 uscale 0.1 0.2 0.9 translate union
/room

1.0 1.0 1.0 point [ ] 1.0 0.0 0.0 point room 1 90.0 16 12 "bounces.ppm" render
