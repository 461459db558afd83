<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1">
<context>
    <name>autobalance</name>
    <message>
        <source>A crank of the generator's presets</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a weight or number is none; expected numbers with ; between them</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>App</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>autobalance was not found. Make a virtual environment and install it there?</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Axis, journals, crankpins, webs and faces as a group</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Balance</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Balance factor</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Balance the selected body</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Balanced crank</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Bob-weight</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Body</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Check every claim of the report</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Crankpin [g]</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Cuts</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Density [kg/m³]</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Drills at hand [mm]</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Factor: what each does</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>FreeCAD's own residual of the tree of cuts: %.2f g mm</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Grade G</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Inspect</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>smallest first order %.3f, smallest maximum force %.3f</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Limits, key=value</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>New crank</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Open the app in a browser</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Open the shop sheet</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Preset of the crank</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Reciprocating weights [g]</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Rod length [mm], 0: none</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Rotating weights [g]</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Sheet</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Size: is the unit right?</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Speed [1/min]</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The cuts as native features</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Verify</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Write job</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Write job and solid to a folder</source>
        <translation type="unfinished"></translation>
    </message>
</context>
</TS>
