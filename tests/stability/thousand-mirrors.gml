% after a thousand reflections rays have drifted through their mirrors
%
% Between two mirrors that reflect 0.998 of the light and give 0.002, the light adds up to 1 -
% 0.998^1001. The distance of the mirrors does not matter.
#include "common.gml"

{ /v /u /face white 0.002 0.998 1.0 } /dim
{ /name /gap
  white [ ] 1.0 0.0 0.0 point
  dim plane -90.0 rotatex 0.0 0.0 gap translate dim plane 90.0 rotatex 0.0 0.0 gap negf translate union
  0.0 0.0 -1.0 translate 1001 20.0 9 9 name render
} /between
1.0 "wide.ppm" between apply
1.0e-7 "narrow.ppm" between apply
