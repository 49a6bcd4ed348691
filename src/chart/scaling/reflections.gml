% A closed room of mirrors: each ray is reflected n times.
{ /v /u /face 0.9 0.95 1.0 point 0.1 0.99 50.0 } /mirror
mirror plane 0.0 -2.0 0.0 translate
mirror plane 180.0 rotatez 0.0 2.0 0.0 translate union
mirror plane -90.0 rotatez -3.0 0.0 0.0 translate union
mirror plane  90.0 rotatez  3.0 0.0 0.0 translate union
mirror plane -90.0 rotatex 0.0 0.0 6.0 translate union
mirror plane  90.0 rotatex 0.0 0.0 -2.0 translate union
{ /v /u /face 1.0 0.8 0.3 point 0.3 0.9 40.0 } sphere -0.8 -0.7 3.0 translate union
/room

0.2 0.2 0.2 point
[ 1.0 1.5 1.0 point 0.5 0.5 0.5 point pointlight ]
room n 90.0 80 60 "reflections.ppm" render
