% A directional light, a point light and a spotlight, with shadows (ICFP attenuation).
{ /v /u /face 0.9 0.9 0.9 point 0.8 0.3 20.0 } /white
white plane 0.0 -1.0 0.0 translate white sphere 0.6 uscale 0.0 -0.4 2.5 translate union /scene
1.0 -1.0 0.5 point 0.3 0.3 0.3 point light /sun
-2.0 1.5 1.0 point 1.0 0.4 0.2 point pointlight /bulb
2.0 3.0 2.0 point 0.5 -1.0 3.0 point 0.2 0.5 1.0 point 20.0 2.0 spotlight /spot
0.1 0.1 0.1 point [ sun bulb spot ] scene 0 80.0 64 48 "lights.ppm" render
