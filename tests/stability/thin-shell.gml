% light steps through a wall that is thinner than the epsilon
%
% A lamp in a box, 1e-8 below the lid, lights nothing outside: no more with walls 1e-9 thick than
% in a box of stone.
#include "common.gml"

white matte apply cube -0.5 -0.5 -0.5 translate /box
[ 0.0 0.49999999 2.0 point 5.0 5.0 5.0 point pointlight ] /lamp
{ /name /lights /object
  lights 0.1 0.1 0.1 point
  object 20.0 rotatey 0.0 0.0 2.0 translate
  orange matte apply sphere 0.4 uscale 0.0 1.2 2.2 translate union
  green matte apply plane 0.0 -0.5 0.0 translate union name lit apply
} /shown
box [ ] "dark.ppm" shown apply
box lamp "stone.ppm" shown apply
box box 0.999999999 uscale difference lamp "paper.ppm" shown apply
