% forty crossings on a ray, sorted and counted
%
% Forty nested balls, united and taken away in turn, cut through the middle. The cut is yellow
% where it is solid.
#include "common.gml"

{ /self /n /rest
  n 0 eqi { rest } {
    rest blue matte apply sphere n real 40.0 divf uscale
    n 2 modi 0 eqi { union } { difference } if
    n 1 subi self self apply
  } if
} /nest

blue matte apply sphere 39 nest nest apply
1.0 1.0 0.0 point matte apply plane -90.0 rotatex intersect 0.0 0.0 1.0 translate
90.0 48 48 "shells.ppm" flat apply
