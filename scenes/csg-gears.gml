% csg-gears.gml - a train of three gears, all of it cut from solid rods (ICFP dialect).
%
% A gear is a rod less a lot: a notch for every gap between teeth, holes to save weight, a
% recess on the face, a bore for the axle. What is cut away is one union, so the difference is
% as wide as it gets, up to 30 solids. A notch is a box on its edge that is stopped by a core.
% Gears mesh when their radii are in proportion to their teeth, and when a tooth of one faces
% a gap of the other.

#include "lib/surfaces.ins"
#include "lib/build.ins"

0.095 /module                                   % radius for each tooth
0.085 /deep                                     % half the height of a tooth
20 /large                                       % teeth of the large gear

0.78 0.8 0.85 point 0.65 0.35 30.0 plain apply /steel
1.0 0.74 0.32 point 0.6 0.4 25.0 plain apply /brass
0.98 0.5 0.34 point 0.6 0.4 25.0 plain apply /copper

% surface count radius size drill -> object: vertical holes on a circle
{ /size /radius /count /surface
  count { /i
    surface cylinder size 3.0 size scale radius -1.5 0.0 translate
    i real 360.0 count real divf mulf rotatey
  } repeat apply
} /drill

% surface teeth gear -> object: axle along y, a gap towards +x
{ /teeth /surface
  teeth real module mulf /pitch
  360.0 teeth real divf /step
  surface cylinder pitch deep addf 0.3 pitch deep addf scale

  teeth { /i                                    % the gaps, down to a core
    surface cube -0.5 -0.5 -0.5 translate 45.0 rotatey 1.41421 uscale
    deep 4.0 mulf 1.0 0.21 scale
    pitch deep addf 0.0 0.0 translate i real step mulf rotatey
  } repeat apply
  surface cylinder pitch deep subf 3.0 pitch deep subf scale 0.0 -1.5 0.0 translate difference

  surface cylinder pitch 0.78 mulf 1.0 pitch 0.78 mulf scale 0.0 0.2 0.0 translate union
  surface teeth 3 divi pitch 0.53 mulf pitch 0.13 mulf drill apply union
  surface cylinder 0.12 3.0 0.12 scale 0.0 -1.5 0.0 translate union
  difference

  surface cylinder 0.26 0.36 0.26 scale         % the hub, bored for the axle
  surface cylinder 0.12 1.0 0.12 scale 0.0 -0.5 0.0 translate difference union
  steel cylinder 0.115 0.46 0.115 scale union
  steel sphere 0.115 0.07 0.115 scale 0.0 0.46 0.0 translate union
} /gear

% surface teeth angle mesh -> object: a gear that drives the large one, at that angle. All have
% an even number of teeth, so half a step brings a tooth to the side of -x.
{ /angle /teeth /surface
  surface teeth gear apply 180.0 teeth real divf rotatey
  teeth large addi real module mulf 0.0 0.0 translate angle rotatey
} /mesh

% The plate: brushed
{ /v /u /face
  v 4000.0 mulf sin v 1730.0 mulf sin addf 0.02 mulf 0.16 addf /tone
  tone tone 1.1 mulf tone 1.3 mulf point 0.85 0.15 15.0
} /plate

brass large gear apply
copper 12 144.0 mesh apply union                % 144 and 36 are multiples of 18, the step
steel 14 36.0 mesh apply union
16.0 rotatey
plate plane 0.0 -0.15 0.0 translate union
-64.0 rotatex 0.3 0.3 8.5 translate /machine

0.3 0.3 0.33 point
[ -4.0 5.0 -1.0 point  1.8 1.7 1.5 point  pointlight
   5.0 1.0 -2.0 point  0.45 0.5 0.65 point  pointlight ]
machine 2 48.0 320 240 "csg-gears.ppm" render
