% normals of flat solids span twelve orders of magnitude
%
% A disc and an ellipsoid, wide and flat, turned and turned back, have tops that
% look like a plane.
#include "common.gml"

green matte apply plane 0.0 -1.0 0.0 translate "plane.ppm" sunny apply
green matte apply cylinder 0.0 -1.0 0.0 translate 1.0e12 1.0e-9 1.0e12 scale
30.0 rotatex 30.0 rotatex -60.0 rotatex 0.0 -1.0 0.0 translate
"disc.ppm" sunny apply
green matte apply sphere 1.0e12 1.0 1.0e12 scale 50.0 rotatez 10.0 rotatez -60.0 rotatez
0.0 -2.0 0.0 translate "ellipsoid.ppm" sunny apply
