% 255 c is a rounding away from an integer, or exactly half of one
%
% A wall with stripes of 0.1 to 0.9: the bytes are those of 255 c in exact arithmetic, rounded
% down.
#include "common.gml"

{ /v /u /face
  u 9.0 mulf floor 1 addi real 10.0 divf /c c c c point 1.0 0.0 1.0
} cube -0.5 -0.5 0.0 translate 2.0 uscale 90.0 45 45 "grays.ppm" flat apply
