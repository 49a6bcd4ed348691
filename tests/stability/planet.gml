% the error of a root grows with the radius: acne on all that is large
%
% Standing on a ball so large that its curvature moves no byte is standing on a plane.
#include "common.gml"

green matte apply plane 0.0 -1.0 0.0 translate "plane.ppm" sunny apply
green matte apply sphere 37.0 rotatex 23.0 rotatey 1.0e13 uscale
0.0 -10000000000001.0 0.0 translate "ball.ppm" sunny apply
