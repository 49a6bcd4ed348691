% roundings of transforms that cancel remain
%
% Turning round in steps, going far away and back, and growing and shrinking leave a die as it
% was.
#include "common.gml"

checkers cube -0.5 -0.5 -0.5 translate /die
{ /name /object object 30.0 rotatex 0.0 0.0 0.8 translate name sunny apply } /shown
{ /self /n /object
  n 0 eqi { object } { object 1.0 rotatey n 1 subi self self apply } if
} /turned
die "die.ppm" shown apply
die 360 turned turned apply "turned.ppm" shown apply
die 1.0e14 3.0e13 0.0 translate 25.0 rotatey
13.0 rotatey -38.0 rotatey -1.0e14 -3.0e13 0.0 translate "far.ppm" shown apply
die 1.0e10 1.0 1.0e-10 scale 1.0e-5 1.0 1.0e5 scale 1.0e-5 1.0 1.0e5 scale "scaled.ppm" shown apply
die -1.0 1.0 1.0 scale 45.0 rotatex -45.0 rotatex -1.0 1.0 1.0 scale "mirrored.ppm" shown apply
