% the cosine of 90 degrees is not 0, and that of an angle not the one of the border
%
% A spotlight at the eye lights a disc; one that looks up lights the upper half, with the
% border.
#include "common.gml"

white matte apply plane -90.0 rotatex 0.0 0.0 3.0 translate /wall
[ 0.0 0.0 -1.0 point 0.0 0.0 5.0 point white 30.0 0.0 spotlight ] none wall "disc.ppm" lit apply
[ 0.0 0.0 -1.0 point 0.0 1.0 -1.0 point white 90.0 0.0 spotlight ] none wall "half.ppm" lit apply
