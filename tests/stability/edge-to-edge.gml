% surfaces that cross at one point of a ray are met one after the other
%
% The eye is within a wedge that touches another one along an edge. Rays through the edge leave the
% one and enter the other at once, so that there is nothing to be seen before its far end.
#include "common.gml"

{ /color color matte apply plane -90.0 rotatez } /west
{ /color color matte apply plane 90.0 rotatez } /east
orange west apply -20.0 rotatey orange east apply 70.0 rotatey intersect /near
blue east apply -20.0 rotatey blue west apply 70.0 rotatey intersect
blue matte apply sphere 9.0 uscale intersect /beyond
near beyond union 10.0 rotatex 0.0 0.0 0.7 translate 90.0 49 49 "wedges.ppm" flat apply
