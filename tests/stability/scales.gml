% a fixed epsilon is too large for small scenes and too small for large ones
%
% The same scene, scaled about the eye, looks the same.
#include "common.gml"

orange matte apply sphere
blue matte apply cube -0.5 -1.6 -0.5 translate union
green matte apply plane 0.0 -1.4 0.0 translate union
20.0 rotatey 0.0 0.0 5.0 translate /scene
{ /name /size scene size uscale 0.0 0.0 -1.0 translate name sunny apply } /scaled
1.0 "one.ppm" scaled apply
1.0e9 "huge.ppm" scaled apply
1.0e-9 "tiny.ppm" scaled apply
