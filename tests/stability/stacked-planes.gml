% of many coincident planes each shows somewhere
%
% Planes that come to lie on one another in different ways. The last operand paints.
#include "common.gml"

orange matte apply plane 0.0 -1.0 0.0 translate
white matte apply plane 3.0 uscale 0.0 -10.0 0.0 translate 0.1 uscale union
white matte apply plane 0.0 0.0 0.0 translate 60.0 rotatex 60.0 rotatex 60.0 rotatex 180.0 rotatez
0.0 -1.0 0.0 translate union
blue matte apply plane 1.0 -1.0 1.0 scale 180.0 rotatez 30.0 rotatey 5.0 -1.0 7.0 translate union
90.0 48 48 "planes.ppm" flat apply
