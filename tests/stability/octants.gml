% cracks open where parts touch
%
% A ball cut into eight along the planes that the eye looks along, and put together again, is
% the ball.
#include "common.gml"

orange matte apply sphere /ball
orange matte apply plane /below
below 180.0 rotatex /above
below -90.0 rotatez /left    below 90.0 rotatez /right
below -90.0 rotatex /back    below 90.0 rotatex /front

{ /name /object
  sun 0.2 0.2 0.2 point object 0.0 0.0 1.0 translate name lit apply
} /shown
ball "ball.ppm" shown apply
ball left intersect below intersect front intersect
ball left intersect below intersect back intersect union
ball left intersect above intersect front intersect union
ball left intersect above intersect back intersect union
ball right intersect below intersect front intersect union
ball right intersect below intersect back intersect union
ball right intersect above intersect front intersect union
ball right intersect above intersect back intersect union "octants.ppm" shown apply
