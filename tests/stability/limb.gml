% where rays graze, coincident surfaces are far apart: the root of an error is larger than the error
%
% The limb of a ball and of a drum, seen through a telescope: half of the picture. Nothing is left
% there either when they are turned and taken away from themselves.
#include "common.gml"

{ /name /object object 1.0 0.0 2.0 translate 1.0e-10 48 48 name flat apply } /shown
orange matte apply sphere /ball
orange matte apply cylinder 0.0 -0.5 0.0 translate /drum
ball "ball.ppm" shown apply
drum "drum.ppm" shown apply
ball ball 17.0 rotatex 29.0 rotatey 41.0 rotatez difference "no-ball.ppm" shown apply
drum drum 33.0 rotatey difference "no-drum.ppm" shown apply
