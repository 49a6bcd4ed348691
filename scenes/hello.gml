% hello.gml - two spheres on a floor, to start from (ICFP dialect).
%
% A surface is a function: it finds face, u and v on the stack and leaves a colour, the shares
% of diffuse and of specular light, and the Phong exponent. The light is a lamp in the room
% and not the sun, so the floor fades into the dark before it gets to the horizon.

{ /v /u /face 0.95 0.25 0.15 point 0.75 0.25 25.0 } /red
{ /v /u /face 1.0 0.75 0.3 point 0.6 0.4 60.0 } /gold
{ /v /u /face 0.5 0.6 0.75 point 0.8 0.2 10.0 } /slate

red sphere -0.55 0.0 3.2 translate /large
gold sphere 0.55 uscale 0.85 -0.45 2.3 translate /small
slate plane 0.0 -1.0 0.0 translate /ground

-3.0 4.0 -1.0 point  1.8 1.7 1.5 point  pointlight /lamp

0.2 0.2 0.3 point  [ lamp ]                  % ambient light and lights
large small union ground union                 % the object: all in one
3  60.0  320 240  "hello.ppm" render           % depth, field of view, size, file
