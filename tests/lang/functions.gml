% One program a line, and behind `%!` the stack it leaves, or `error CODE at COLUMN`.
1 /x { x } /f 2 /x f apply x addi %! 3
{ /x x x } /dup 3 dup apply addi %! 6
{ /self /n n 2 lessi { 1 } { n 1 subi self self apply n muli } if } /fact 12 fact fact apply %! 479001600
{ /self /n n 2 lessi { n } { n 1 subi self self apply n 2 subi self self apply addi } if } /fib 20 fib fib apply %! 6765
{ /self /n n 0 eqi { 42 } { n 1 subi self self apply } if } /down 25000 down down apply %! 42
{ /self /n n 0 eqi { 0 } { n 1 subi self self apply 1 addi } if } /up 25000 up up apply %! 25000
1 2 3 { addi } apply %! 1 5
true { 1 } { 2 } if false { 1 } { 2 } if %! 1 2
1 true { 2 } { 3 4 } if %! 1 2
1 false { 2 } { 3 4 } if %! 1 3 4
{ 1 } { 2 } /b /a true a b if false a b if %! 1 2
true { 1 } /a a { 2 } if %! 1
1 2 lessi { 10 } { 20 } if %! 10
{ /c c { /x x 1 addi } { /x x 1 subi } if } /step 5 true step apply 5 false step apply %! 6 4
{ /c 1 2 c { addi } { subi } if } /g true g apply false g apply %! 3 -1
{ /c c { 7 } { 1 2 } if } /h true h apply false h apply %! 7 1 2
{ /c 1 c { /y y y } { 5 /y y 9 } if } /k true k apply false k apply %! 1 1 1 5 9
{ /a { /b { /c a b addi c addi } } } /curry 3 2 1 curry apply apply apply %! 6
1 /x { 2 /x x } apply x %! 2 1
true { 2 /x x } { } if x %! error E0102 at 24
x %! error E0102 at 1
true { } { 5 0 divi x } if %!
{ y } /f 1 /y f apply %! error E0102 at 3
{ /f f f apply } /omega 1 %! 1
1 apply %! error E0201 at 3
apply %! error E0101 at 1
1 { 1 } { 2 } if %! error E0201 at 15
true 1 { 2 } if %! error E0201 at 14
true { 2 } 1 if %! error E0201 at 14
{ 1 } { 2 } if %! error E0101 at 13
/x %! error E0101 at 1
{ /x } apply %! error E0101 at 3
{ /a /b } /f 1 f apply %! error E0101 at 6
{ /a /b /c } /f 1 2 f apply %! error E0101 at 9
{ /a /b a b subi } /rsub 1 10 rsub apply %! 9
{ /n { /m m n muli } } /mul 6 7 mul apply apply %! 42
0 /zero { zero } /get-zero 1 /zero get-zero apply %! 0
{ } apply %!
{ { 1 } } apply apply %! 1
1.5 /x { x x mulf } apply { x } apply %! 2.25 1.5
{ /b /a a b lessf { a } { b } if } /min 1.0 2.0 min apply 3.0 2.0 min apply %! 1.0 2.0
{ /v v getx v gety v getz } /parts 1.0 2.0 3.0 point parts apply %! 1.0 2.0 3.0
{ /p p 0.0 lessf { true } { false } if { 1 } { 2 } if } /q -1.0 q apply 1.0 q apply %! 1 2
{ 1 { 2 { 3 { 4 { 5 } apply } apply } apply } apply } apply %! 1 2 3 4 5
{ /self /n /acc n 0 eqi { acc } { acc n addi n 1 subi self self apply } if } /sum 0 100 sum sum apply %! 5050
1 /x { x } /f 2 /x { f apply x } apply %! 1 2
1 /x 2 /x x %! 2
1 /x { x 2 /x x } apply x %! 1 2 1
1 /x true { x 2 /x x } { } if x %! 1 2 1
false { } { 1 /y y } if y %! error E0102 at 25
{ 1 /y } apply y %! error E0102 at 16
true { false } { true } if { 1 } { 2 } if %! 2
{ { { 1 } } } apply apply apply %! 1
{ /f 1 f apply } /with-one { 2 addi } with-one apply %! 3
{ /g /f { f apply g apply } } /then { 1 addi } { 2 muli } then apply /h 4 h apply %! 10
{ /odd /even /n n 0 eqi { true } { n 1 subi even odd odd apply } if } /even { /odd /even /n n 0 eqi { false } { n 1 subi even odd even apply } if } /odd 7 even odd even apply %! false
{ /odd /even /n n 0 eqi { true } { n 1 subi even odd odd apply } if } /even { /odd /even /n n 0 eqi { false } { n 1 subi even odd even apply } if } /odd 8 even odd even apply %! true
{ } { } true 3 if %! error E0201 at 16
true { 1 } { 2 } /f f if %! 1
true { 1 } { } { } apply if %! 1
{ /a if } /f true { 1 } { 2 } 9 f apply %! 1
{ /a if } /f 1 9 f apply %! error E0101 at 6
{ 1 0 divi } /f true { 5 } f if %! 5
{ 1 0 divi } /f f apply %! error E0302 at 7
{ x } /f 1 2 f apply %! error E0102 at 3
{ 1 addi } /f true f apply %! error E0201 at 5
{ /x /y x } /f 1 f %! 1 {...}
0 { 1 } { 2 } if %! error E0201 at 15
{ } { 1 } { 2 } if %! error E0201 at 17
"s" apply %! error E0201 at 5
[ { } ] apply %! error E0201 at 9
{ apply } /f f apply %! error E0101 at 3
{ /x x addi } /f 1 f apply %! error E0101 at 8
{ 1 { 2 { addi } apply } apply } apply %! 3
{ /self /n n 0 eqi { } { n 1 subi self self apply } if } /run 100000 run run apply %!
1 /x { /a x { 2 /x x } apply x } /f 0 f apply %! 1 2 1
{ /a a { x } { } if { 2 /x x } apply 3 /x x } /f false f apply %! 2 3
{ /a { 2 /x x } apply x } /f 0 f apply %! error E0102 at 23
