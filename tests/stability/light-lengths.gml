% the square of a direction's length is 0, or infinite
%
% The direction of a light has no length.
#include "common.gml"

green matte apply sphere 0.0 0.0 1.5 translate /ball
{ /name /k
  0.2 0.2 0.2 point [ k k negf k point white light ] 1.0 0.0 0.0 point ball 1 60.0 48 48 name render
} /shown
1.0 "one.ppm" shown apply
1.0e180 "long.ppm" shown apply
1.0e-180 "short.ppm" shown apply
