% b^2 - 4ac loses a sphere in the square of its distance
%
% Unit spheres 1e4, 1e6 and 1e8 away, seen through a telescope that shows all of each. The
% outline is a circle.
#include "common.gml"

orange matte apply sphere /ball
{ /name /distance
  ball 0.0 0.0 distance 1.0 subf translate 148.96902673401403 distance divf 48 48 name flat apply
} /far
1.0e4 "near.ppm" far apply
1.0e6 "far.ppm" far apply
1.0e8 "farther.ppm" far apply
