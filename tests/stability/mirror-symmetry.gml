% roundings on the left are not those on the right, and mirrors magnify them
%
% A room of mirrors that is its own mirror image has a picture that is, too.
#include "common.gml"

{ /v /u /face v 16.0 mulf floor 2 modi 0 eqi { white } { blue } if 0.1 0.95 1.0 } /stripes
stripes sphere 5.0 uscale 0.0 0.0 2.0 translate
white mirror apply sphere /ball
ball -1.05 -0.6 4.0 translate union
ball 1.05 -0.6 4.0 translate union
ball 0.0 1.2 4.0 translate union
ball 0.0 0.0 5.6 translate union /room
white [ ] 1.0 0.0 0.0 point room 80 60.0 48 48 "mirrors.ppm" render
