% One program a line, and behind `%!` the stack it leaves, or `error CODE at COLUMN`.
[ 1 2 [ 3 ] { 4 } ] length %! 4
[ 1 2 [ 3 ] { 4 } ] %! [ 1 2 [ 3 ] {...} ]
[] length [] %! 0 [ ]
5 [ 1 2 addi ] 0 get addi %! 8
5 [ 1 addi ] %! error E0101 at 7
5 [ /x ] %! error E0101 at 5
5 [ { /x } apply ] %! error E0101 at 7
5 { /x } /pop [ pop apply ] %! error E0101 at 5
[ 7 8 9 ] 1 get %! 8
[ 7 8 9 ] 3 get %! error E0304 at 13
[ 7 8 9 ] -1 get %! error E0304 at 14
[] -1 get %! error E0304 at 7
[ 7 ] 0.0 get %! error E0201 at 11
7 0 get %! error E0201 at 5
[ 1 /x x x ] x %! error E0102 at 14
1 /x [ 2 /x x ] x %! [ 2 ] 1
{ /a a 0 get } /first [ [ 5 ] ] first apply first apply %! 5
[ 1 { 2 3 } apply 4 ] %! [ 1 2 3 4 ]
{ 2 3 } /two [ 1 two apply 4 ] %! [ 1 2 3 4 ]
9 { 2 3 } /two [ 1 two apply 4 ] %! 9 [ 1 2 3 4 ]
{ /n [ n n 1 addi ] } /pair 5 pair apply 7 pair apply %! [ 5 6 ] [ 7 8 ]
{ /n [ n [ n ] { n } ] } /nest 5 nest apply 2 get apply %! 5
{ /c [ 1 c { 2 3 } { 4 } if 5 ] } /vary true vary apply false vary apply %! [ 1 2 3 5 ] [ 1 4 5 ]
{ /self /n n 0 eqi { } { n n 1 subi self self apply } if } /count [ 5 count count apply ] %! [ 5 4 3 2 1 ]
{ /self /n n 0 eqi { } { n n 1 subi self self apply } if } /count [ 25000 count count apply ] length %! 25000
1.0 2.0 3.0 point %! 1.0 2.0 3.0 point
1.0 2.0 3.0 point /p p getx p gety p getz %! 1.0 2.0 3.0
1.0 2 3.0 point %! error E0201 at 11
1 getx %! error E0201 at 3
"a string: \ % [ { " %! "a string: \ % [ { "
true false %! true false
{ 1 } sphere %! <object>
{ 1 } sphere 1.0 2.0 3.0 translate { 1 } cube union %! <object>
0.0 0.0 1.0 point 1.0 1.0 1.0 point light %! <light>
{ 1 } sphere 1.0 0.0 1.0 scale %! error E0306 at 26
{ 1 } sphere 0.0 uscale %! error E0306 at 18
{ 1 } sphere 1.0 0.0 divf rotatex %! error E0306 at 27
{ 1 } sphere 1.0 2.0 3 translate %! error E0201 at 24
1 sphere %! error E0201 at 3
1.0 1.0 1.0 point light %! error E0101 at 19
1.0 1.0 1.0 point [ 1 ] { 1 } sphere 1 90.0 2 2 "x" render %! error E0307 at 53
1.0 1.0 1.0 point [ ] { 1 } sphere 1 180.0 2 2 "x" render %! error E0307 at 52
1.0 1.0 1.0 point [ ] { 1 } sphere 1 90.0 0 2 "x" render %! error E0307 at 51
1.0 1.0 1.0 point [ ] { 1 } sphere 1 90 2 2 "x" render %! error E0201 at 49
[ [ 1 2 ] [ 3 [ 4 5 ] ] ] 1 get 1 get 0 get %! 4
[ { 1 } { 2 } ] 1 get apply %! 2
[ true 1 2.0 "s" 0.0 0.0 0.0 point { } { } sphere ] length %! 7
[ 1 2 3 ] /a [ a 2 get a 1 get a 0 get ] a %! [ 3 2 1 ] [ 1 2 3 ]
[ [ ] [ [ ] ] ] length %! 2
[ 7 ] 9223372036854775807 get %! error E0304 at 27
[ 7 ] 1 get %! error E0304 at 9
[ [ 7 ] 0 get ] 1 get %! error E0304 at 19
[ 1 2 ] { 0 } apply get %! 1
[ { [ 1 } apply ] %! error E0006 at 9
[ 1 { 2 /x x x } apply ] %! [ 1 2 2 ]
3 /n [ n { /n n 1 addi } apply ] %! [ 4 ]
3 /n [ n 4 /n n { n 5 /n n } apply n ] n %! [ 3 4 4 5 4 ] 3
[ 1 2 3 length ] %! error E0201 at 9
{ } sphere -1.0 1.0 1.0 scale %! <object>
{ } cube 0.0 0.0 0.0 point 1 0 divi %! error E0302 at 32
{ } cube 1e300 uscale 1e300 uscale %! error E0306 at 29
{ } cube 1e-300 uscale 1e-300 uscale %! error E0306 at 31
{ } cube 1.0 1.0 -0.0 scale %! error E0306 at 23
{ } cube 0.0 0.0 divf 0.0 0.0 translate %! error E0306 at 31
{ } cube 1.0 0.0 divf 1.0 1.0 scale %! error E0306 at 31
{ } cube 0.0 0.0 divf uscale %! error E0306 at 23
{ } cube 0.0 0.0 divf rotatez %! error E0306 at 23
{ } cube { } plane { } cone union intersect %! <object>
0.0 0.0 0.0 point 0.0 0.0 0.0 point 1.0 1.0 1.0 point 30.0 2.0 spotlight %! <light>
1.0 1.0 1.0 point [ ] 1.0 0.0 0.0 point { } sphere 1 180.0 2 2 "x" render %! error E0307 at 68
1.0 1.0 1.0 point [ ] 1.0 0.0 0.0 point { } sphere 1 90.0 2 -1 "x" render %! error E0307 at 68
1.0 1.0 1.0 point 1.0 0.0 0.0 point { } sphere 1 90.0 2 2 "x" render %! error E0101 at 63
1.0 1.0 1.0 point { } { } sphere 1 90.0 2 2 "x" render %! error E0201 at 49
1.0 1.0 1.0 point [ ] 1.0 { } sphere 1 90.0 2 2 "x" render %! error E0201 at 53
1.0 1.0 1.0 point 7 1.0 0.0 0.0 point { } sphere 1 90.0 2 2 "x" render %! error E0201 at 65
7 [ ] 1.0 0.0 0.0 point { } sphere 1 90.0 2 2 "x" render %! error E0201 at 51
[ ] 1.0 0.0 0.0 point { } sphere 1 90.0 2 2 "x" render %! error E0101 at 49
1.0 1.0 1.0 point [ ] { } sphere 1 0.0 2 2 "x" render %! error E0307 at 48
1.0 1.0 1.0 point [ ] { } sphere 1 0.0 0.0 divf 2 2 "x" render %! error E0307 at 57
1.0 1.0 1.0 point [ ] { } sphere 1 90.0 4294967296 2 "x" render %! error E0307 at 58
