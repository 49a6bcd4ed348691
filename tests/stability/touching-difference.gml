% the face that two solids share is cut away, or painted by the wrong one
%
% Taking away solids that only touch a cube leaves the cube.
#include "common.gml"

orange matte apply cube /cube0
{ -0.5 -0.5 -0.5 translate 25.0 rotatex 35.0 rotatey 0.0 0.0 1.5 translate } /place
cube0 place apply "cube.ppm" sunny apply
cube0 blue matte apply cube -1.0 0.0 0.0 translate difference
blue matte apply cylinder 180.0 rotatex 0.5 uscale 0.5 0.0 0.5 translate difference
blue matte apply cone 0.4 uscale 0.5 1.0 0.5 translate difference
place apply "cut.ppm" sunny apply
