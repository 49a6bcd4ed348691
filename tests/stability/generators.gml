% a is 0, or nearly, for rays parallel to a side of a cone
%
% The middle column of 45, in the first and last row of 46, looks along generators. Turning a
% cone about its axis, and mirroring it, changes nothing.
#include "common.gml"

orange matte apply cone /funnel
{ /name /object
  0.2 0.2 0.2 point [ 1.0 -1.0 1.0 point white light -1.0 1.5 1.0 point blue light ]
  1.0 0.0 0.0 point object 1.5 uscale 0.0 0.75 2.0 translate
  1 90.0 45 46 name render
} /shown
funnel "plain.ppm" shown apply
funnel 1.0 rotatey 36.0 rotatey -90.0 rotatey "turned.ppm" shown apply
funnel -1.0 1.0 1.0 scale "mirrored.ppm" shown apply
funnel 1.0 1.0 -1.0 scale 45.0 rotatey "both.ppm" shown apply
