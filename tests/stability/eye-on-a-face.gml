% what the eye touches is not seen, or blocks the view
%
% The eye is 1e-8 in front of a face, on it, and as far behind it.
#include "common.gml"

{ /v /u /face face 0 eqi { orange } { blue } if 1.0 0.0 1.0 } cube
-0.5 -0.5 0.0 translate 2.0 uscale 0.0 0.0 -1.0 translate /box
{ /name /shift box 0.0 0.0 shift translate 90.0 48 48 name flat apply } /shown
1.0e-8 "before.ppm" shown apply
0.0 "on.ppm" shown apply
-1.0e-8 "behind.ppm" shown apply
