% rays that graze a plane meet it far away, or nearer than the epsilon
%
% The plane fills the lower half of the picture, whatever its distance from the eye.
#include "common.gml"

[ 0.0 -1.0 0.0 point 0.5 0.5 0.5 point light ] /zenith
{ /name /depth
  none zenith 1.0 0.0 0.0 point white matte apply plane 0.0 depth negf 0.0 translate
  1 170.0 48 48 name render
} /ground
1.0 "one.ppm" ground apply
1.0e9 "far.ppm" ground apply
1.0e-9 "near.ppm" ground apply
