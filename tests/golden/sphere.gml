% A sphere with its texture coordinates as colours, lit from the upper left.
{ /v /u /face u v 0.5 point 0.9 0.2 6.0 } sphere 20.0 rotatex 0.0 0.0 1.2 translate /scene
1.0 -1.0 1.0 point 0.9 0.9 0.9 point light /sun
0.2 0.2 0.2 point [ sun ] scene 0 60.0 64 48 "sphere.ppm" render
