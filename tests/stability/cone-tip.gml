% near the apex of a cone b^2 - 4ac is all rounding
%
% The tip of a cone, seen from the side through a telescope: two generators cross the picture.
#include "common.gml"

orange matte apply cone 1.0e-6 48 48 "tip.ppm" flat apply
