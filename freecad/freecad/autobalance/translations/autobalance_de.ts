<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="de">
<context>
    <name>autobalance</name>
    <message>
        <source>A crank of the generator's presets</source>
        <translation>Eine Kurbelwelle aus den Vorlagen</translation>
    </message>
    <message>
        <source>a weight or number is none; expected numbers with ; between them</source>
        <translation>ein Gewicht oder eine Zahl ist keine; erwartet: Zahlen mit ; dazwischen</translation>
    </message>
    <message>
        <source>App</source>
        <translation>App</translation>
    </message>
    <message>
        <source>autobalance was not found. Make a virtual environment and install it there?</source>
        <translation>autobalance wurde nicht gefunden. Eine virtuelle Umgebung anlegen und dort installieren?</translation>
    </message>
    <message>
        <source>Axis, journals, crankpins, webs and faces as a group</source>
        <translation>Achse, Lagerzapfen, Hubzapfen, Wangen und Flächen als Gruppe</translation>
    </message>
    <message>
        <source>Balance</source>
        <translation>Wuchten</translation>
    </message>
    <message>
        <source>Balance factor</source>
        <translation>Massenausgleichsgrad</translation>
    </message>
    <message>
        <source>Balance the selected body</source>
        <translation>Den gewählten Körper wuchten</translation>
    </message>
    <message>
        <source>Balanced crank</source>
        <translation>Gewuchtete Kurbelwelle</translation>
    </message>
    <message>
        <source>Bob-weight</source>
        <translation>Meistergewicht</translation>
    </message>
    <message>
        <source>Body</source>
        <translation>Körper</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>Abbrechen</translation>
    </message>
    <message>
        <source>Check every claim of the report</source>
        <translation>Jede Angabe des Berichts prüfen</translation>
    </message>
    <message>
        <source>Crankpin [g]</source>
        <translation>Hubzapfen [g]</translation>
    </message>
    <message>
        <source>Cuts</source>
        <translation>Schnitte</translation>
    </message>
    <message>
        <source>Density [kg/m³]</source>
        <translation>Dichte [kg/m³]</translation>
    </message>
    <message>
        <source>Drills at hand [mm]</source>
        <translation>Vorhandene Bohrer [mm]</translation>
    </message>
    <message>
        <source>Factor: what each does</source>
        <translation>Faktor: was jeder bewirkt</translation>
    </message>
    <message>
        <source>FreeCAD's own residual of the tree of cuts: %.2f g mm</source>
        <translation>FreeCADs eigene Restunwucht des Baums der Schnitte: %.2f g mm</translation>
    </message>
    <message>
        <source>Grade G</source>
        <translation>Gütestufe G</translation>
    </message>
    <message>
        <source>Inspect</source>
        <translation>Untersuchen</translation>
    </message>
    <message>
        <source>smallest first order %.3f, smallest maximum force %.3f</source>
        <translation>kleinste erste Ordnung %.3f, kleinste größte Kraft %.3f</translation>
    </message>
    <message>
        <source>Limits, key=value</source>
        <translation>Grenzen, Schlüssel=Wert</translation>
    </message>
    <message>
        <source>New crank</source>
        <translation>Neue Kurbelwelle</translation>
    </message>
    <message>
        <source>Open the app in a browser</source>
        <translation>Die App im Browser öffnen</translation>
    </message>
    <message>
        <source>Open the shop sheet</source>
        <translation>Das Werkstattblatt öffnen</translation>
    </message>
    <message>
        <source>Preset of the crank</source>
        <translation>Vorlage der Kurbelwelle</translation>
    </message>
    <message>
        <source>Reciprocating weights [g]</source>
        <translation>Oszillierende Gewichte [g]</translation>
    </message>
    <message>
        <source>Rod length [mm], 0: none</source>
        <translation>Pleuellänge [mm], 0: keine</translation>
    </message>
    <message>
        <source>Rotating weights [g]</source>
        <translation>Rotierende Gewichte [g]</translation>
    </message>
    <message>
        <source>Sheet</source>
        <translation>Blatt</translation>
    </message>
    <message>
        <source>Size: is the unit right?</source>
        <translation>Größe: stimmt die Einheit?</translation>
    </message>
    <message>
        <source>Speed [1/min]</source>
        <translation>Drehzahl [1/min]</translation>
    </message>
    <message>
        <source>The cuts as native features</source>
        <translation>Die Schnitte als eigene Formelemente</translation>
    </message>
    <message>
        <source>Verify</source>
        <translation>Prüfen</translation>
    </message>
    <message>
        <source>Write job</source>
        <translation>Auftrag schreiben</translation>
    </message>
    <message>
        <source>Write job and solid to a folder</source>
        <translation>Auftrag und Körper in einen Ordner schreiben</translation>
    </message>
</context>
</TS>
