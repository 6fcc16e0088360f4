"""Words in the names of columns, in the languages and the shorthand that people and instruments write.

All are in small letters, without signs and accents.
"""

from __future__ import annotations

import re
import unicodedata


def set_of(text: str) -> frozenset[str]:
    """The words of a text as a set, without accents and with Korean syllables apart, as words of names are."""
    letters = unicodedata.normalize("NFKD", text)
    return frozenset(re.sub("[\u0300-\u036f]", "", letters).split())


# Names in small letters without signs and accents; a column of another unit than the signal's is no candidate.
NAMES = {
    "field": "field e i u b v voltage current coilcurrent icoil drivecurrent command cmd excitation pwm duty volt amp "
    "amps cur curr strom spannung spulenstrom feld courant tension corriente voltaje tensao corrente tensione iq id "
    "uq ud ia udc hv highvoltage hochspannung "
    "h coil fluxdensity magneticfluxdensity magneticflux flux bfield flussdichte induction inducao induccion "
    "磁感应强度 磁通密度 磁束密度 磁场强度 磁場強度 电场强度 電界強度 电流 电压 励磁电流 线圈电流 電流 電圧 "
    "pradcewki bobinakımı spoelstroom spanning spänning virta jannite intensite intensidad campomagnetico "
    "champmagnetique magnetfeld inductionmagnetique corrientedebobina courantdebobine 磁场 磁場 자기장 "
    "占空比 デューティ デューティ比 デューティサイクル 듀티 듀티비 듀티사이클 "
    "iexc imag ispule uspule vcoil ucoil imr feldstarke kaamivirta proudcivky aram feszultseg dongđien "
    "магнитнаяиндукция "
    "cour spg stromstarke ток напряжение 전류 전압 prad napiecie proud napeti stroom akım gerilim",
    "slip": "slip w v n omega speed velocity vel sliprate slipspeed shearrate gammadot relativespeed rpm anglevelocity "
    "vs vrel drehzahl geschwindigkeit winkelgeschwindigkeit schlupf vitesse velocidad velocidade velocita "
    "thetadot dtheta thetad xdot dx dxdt xd dq qd qdot qvel ydot dy phidot dphi angvel velo spd rotationspeed "
    "速度 转速 角速度 滑差 轉速 回転数 回転速度 "
    "скорость обороты частотавращения угловаяскорость 속도 각속도 회전수 회전속도 predkosc predkoscobrotowa "
    "obroty rychlost otacky snelheid toerental varvtal hastighet hız rotacao giri devir nopeus hoeksnelheid "
    "ω omegarel vinkelhastighet kierrosluku kulmanopeus fordulatszam vongquay tocđo nist nact 转速差 "
    "revoluciones umdrehungen winkelgeschw predkosckatowa drehz geschw gesch vit sebesseg szogsebesseg",
    "position": "position pos x d displacement disp stroke travel angle slipangle weg winkel hub verschiebung "
    "deplacement desplazamiento deslocamento spostamento posicion posicao angulo "
    "theta phi q qpos y s encoder enc extension crosshead drehwinkel auslenkung posizione spostamento carrera course "
    "位移 角度 转角 位置 行程 変位 ストローク "
    "перемещение положение угол ход 변위 위치 각도 przemieszczenie połozenie poloha uhel verplaatsing "
    "positie hoek vinkel konum elongation allongement elongacion alargamiento alongamento allungamento verlangerung "
    "verlaengerung wydluzenie curso corsa angolo kat skok yerdegistirme acı posun forskjutning lage siirtyma "
    "伸长 伸び 伸长量 удлинение θ displ positionangulaire 回転角 회전각 스트로크 ходпоршня slaglangd "
    "kulma strok zdvih elmozdulas loket",
    "effort": "effort force torque f m load moment shearstress tau t te drehmoment kraft moment couple fuerza par "
    "forca coppia forza fx fy fz mx my mz tx ty tz loadcell torq trq tor frc schubspannung torsion effet dampingforce "
    "dampkraft friction tauf taufric reibung frottement 摩擦力 力 扭矩 转矩 力矩 载荷 荷载 阻尼力 荷重 トルク "
    "момент крутящиимомент сила усилие нагрузка 토크 힘 하중 모멘트 마찰력 siła sila kracht koppel vridmoment "
    "obciazenie kuvvet tork ff ffric binario momentotorcente voima vaantomomentti remkoppel momenthamujacy "
    "momentobrotowy silatlumienia siłatłumienia sonumlemekuvveti frentorku torquedefreno torquedefrenagem "
    "tq tbrake mbrems mbremse fmeas tmeas momenthamowania siłatłumika remkracht dempkracht jarrumomentti sonumkuvveti "
    "torquedofreio effortamortisseur "
    "制动力矩 制动力 감쇠력 제동토크 제동력 drehm drehmom cple fd fmr md nyomatek forgatonyomatek ero",
    "E1": "e1 field1 ech1",
    "E2": "e2 field2 ech2",
    "E": "e field",
    "theta": "theta motorangle",
    "theta_dot": "thetadot dtheta motorspeed",
    "alpha": "alpha outputangle",
    "alpha_dot": "alphadot dalpha outputspeed",
    "alpha_raw": "alpharaw screwposition tableposition",
    "T": "torque effort t",
    "motor_torque": "motortorque torquecommand torquecmd",
}
SINGLE = ("field", "slip", "position", "effort")
#: Words that a point behind them makes short for a name, and that are no name without it: ``Kr.``, ``Str. [A]``.
SHORT_WITH_A_POINT = {
    short: whole
    for short, _, whole in (
        pair.partition("=")
        for pair in (
            "kr=kraft mom=moment str=strom sp=spannung wink=winkel ang=angle corr=corriente fza=fuerza frz=forza "
            "depl=deplacement desp=desplazamiento despl=desplazamiento spost=spostamento verst=verschiebung "
            "versch=verschiebung geschwind=geschwindigkeit forc=force displ=displacement veloc=velocity volt=voltage "
            "amp=amps tens=tension"
        ).split()
    )
}
#: Words for one signal of several joints, as lists and matrices of a robot are called: joint_velocities_3.
OF_SEVERAL = {
    "positions": "position",
    "speeds": "speed",
    "velocities": "velocity",
    "torques": "torque",
    "efforts": "effort",
    "forces": "force",
    "currents": "current",
    "angles": "angle",
    "voltages": "voltage",
    "loads": "load",
    "moments": "moment",
}
# Words beside the name that say where or how it was measured.
BESIDE = set_of(
    "measured meas mea msr actual act ist mess gemessen sensor filtered filt motor engine output brake clutch damper "
    "shaft piston angular rotational linear relative total machine cart friction cell du de der des moteur "
    "exp experimental mesure mesuree medida compensate compensated corrected raw value j feedback fb fbk fdb "
    "front rear left right upper lower inner outer fl fr rl rr vorn vorne hinten links rechts avant arriere "
    "gauche droite izq izquierda izquierdo derecha derecho sinistra destra sinistro destro esquerda direita esq dir "
    "sx dx lh rh straingauge zeroed tared tariert sum summe gesamt somme suma somma"
)
#: Those of them that say that it was measured.
MEASURED = set_of("measured meas mea msr actual act ist gemessen")
#: Words of what a drive was told, and of what is neither signal: no guess is made from the unit of such a column.
TOLD = set_of(
    "setpoint set target desired demand demanded commanded command cmd ref reference goal soll consigne consigna "
    "setpt sollwert ziel objetivo consegna requested request req feedforward dem sp "
    "deseado deseada desejado desejada desiderato desiderata referencia riferimento souhaite souhaitee voulu voulue "
    "zadany zadana zadane pozadovany gewenst gewenste hedef istenen borvarde ohje asetus "
    "заданный заданная заданное задание уставка целевой целевая целевое требуемый требуемая"
)
#: What a Chinese, Japanese or Korean compound is called by that was told to a supply or a drive.
EASTERN_TOLD = (
    *("设定", "設定", "目标", "目標", "指令", "给定", "給定", "命令", "期望", "参考", "参照"),
    *("설정", "목표", "지령", "기준"),
)
#: And that was computed.
EASTERN_COMPUTED = (
    *(
        "估计",
        "估計",
        "预测",
        "預測",
        "予測",
        "推定",
        "仿真",
        "模拟",
        "模擬",
        "计算",
        "計算",
        "模型",
        "理论",
        "理論",
    ),
    *("추정", "예측", "계산", "모의", "이론"),
)
#: Words that say in which sense a device moves, in a column beside a speed without a sign.
SENSES = set_of(
    "cw ccw clockwise counterclockwise anticlockwise forward forwards fwd backward backwards back bwd reverse rev left "
    "right up down upward downward in out push pull compression rebound bump extension extend retract positive "
    "negative pos neg vor vorwarts ruck ruckwarts zuruck links rechts auf ab zug druck avant arriere gauche "
    "droite traction adelante atras izquierda derecha"
)
OTHER = set_of(
    "layer layers schicht couche capa strato camada leverarm hebelarm "
    "pressure druck pression presion presiones pressione pressao temperature temp esc vibration gap diameter thickness "
    "separation abstand werkzeugabstand "
    "noise error normal accuracy resolution power viscosity strain crack radius size length width mass weight h fn "
    "orient orientation orientacion ausrichtung quat quaternion "
    "horsepower count counts cycle cycles index sample samples no nr number frame packet seq row rows point points "
    "acceleration accelerazione accel acc accx accy accz beschleunigung aceleracion jerk humidity energy efficiency "
    "accelerations "
    "wirkungsgrad leistung puissance potencia temperatur temperatura stiffness hardness harte haerte durete dureza "
    "durezza modulus emodul gradient gradiente coefficient coeff mu density inertia "
    "longitud longueur comprimento lunghezza masa masse massa segmento odkształcenie odksztalcenie laps "
    "dehnung stauchung querdehnung zugspannung druckspannung contrainte deformation deformacion deformacao "
    "yield wear film area volume cof latitude longitude altitude date datum fecha err fehler latency delay dt "
    "viscosidad viscosite viskositat viscosidade viscosita lepkosc viskozite viscositeit viskozita 粘度 점도 "
    "temperatuur sıcaklık teplota lampotila frequencia frekans taajuus frecuencia frequence frequenz frequenza "
    "czestotliwosc частота 주파수 "
    "давление температура вязкость деформация цикл циклы циклов нормальная нормальное "
    "zyklus zyklen lastspiel lastspiele lastwechsel ciclo ciclos cicli cykl cykle cyklus cykly "
    "サイクル 사이클 횟수 반복수 변형률 응력 온도 압력 마찰계수 수직력 수직하중 "
    "normale normalna normalny normalkraft normallast anpresskraft "
    "reibwert reibzahl reibungszahl reibungskoeffizient reibkoeffizient coeficiente coefficiente "
    "коэффициент wspołczynnik"
)
#: What was computed or bounds a measurement is none.
NOT_MEASURED = set_of(
    "predicted pred estimated est estimate simulated sim model calc calculated computed theoretical expected limit max "
    "min std var offset bias residual fit fitted ideal nominal peak design diseno prev previous hat prediction "
    "reconstructed observer clipped saturated gain cutoff stall "
    "geschatzt geschaetzt berechnet simuliert modell estime estimee calcule calculee simule simulee modele "
    "prevu prevue estimado estimada calculado calculada simulado simulada modelo previsto prevista stimato "
    "stimata calcolato calcolata simulato simulata modello szacowany szacowana obliczony obliczona "
    "geschat berekend beraknad tahmini hesaplanan оценка расчет расчетный расчетная расчетное модель прогноз"
)
#: What the parts of an effort are called that a model adds up.
PARTS_OF_A_MODEL = set_of(
    "gravity gravitational friction damping damper inertia inertial coriolis centrifugal viscous coulomb spring "
    "elastic aero aerodynamic drag static stiction schwerkraft gravitation reibung reib daempfung dampfung traegheit"
)
#: Models of friction and networks: a column of such a name holds what a model says of the effort.
MODELS = set_of("dahl lugre stribeck boucwen svm svr pinn lstm gru mlp ann gms maxwellslip")
# Words that turn the head of a name to another thing than the device's own signal.
AGAINST = {
    "field": set_of("battery supply bus link sensor cell strain batt bat psu vbat cc dark leak shunt hall lvdt gauge "
    "hallsensor hallsonde "
                  "gage potentiometer pot poti tacho tachometer transducer thermocouple thermistor photodiode adc "
                  "led lamp fan heater payload leakage capteur straingauge stromsensor stromwandler spannungssensor "
                  "mains netz netzstrom batteriestrom loop ripple mode enable enabled status"),
    "slip": set_of("rolling entrainment wind air fan pump flow sound stream freestream data frequency freq frequenz "
                 "frame sampling refresh ball mode enable enabled ok status override critical synchronous idle ratio "
                 "ripple constant vehicle"),
    "position": set_of("throttle valve pedal gps cursor mouse time phase attack incidence home initial start mode "
                     "enable status"),
    "effort": set_of("ball clamp gravity preload clamping gewichts disturbance disturb dist constant ripple rate mode "
                     "enable enabled ok status"),
}  # fmt: skip
#: Whose effort is what a loop tells a drive, often in volts.
LOOPS = frozenset({"control", "controller", "ctrl", "pid"})
#: Short names that mean several things.
NEED_UNIT = set_of(
    "v vs vrel t m d n e u b h x tau ff load id te par tension q y s phi qd dq dx dy xd course effet torsion id "
    "friction reibung frottement fx fy fz mx my mz tx ty tz fd fmr"
)
VOLTAGES = set_of(
    "u v uq ud udc voltage volt spannung tension voltaje tensao tensione 电压 電圧 전압 "
    "напряжение gerilim napiecie napeti jannite"
)
CURRENTS = set_of(
    "i iq id idc current strom courant corriente corrente amp amps cur curr 电流 電流 전류 ток prad "
    "proud akım stroom virta"
)
#: What the time from row to row is called, where each row has its own.
STEPS_OF_TIME = frozenset({"dt", "deltat", "timestep", "looptime", "cycletime", "zykluszeit"})
#: What a file calls the number that a sensor or its converter gives where its signal is zero.
ZEROS = set_of(
    "zero offset tare tara nullpunkt nullsignal nullpunktspannung nullwert null cero zeropoint midpoint bias"
)
#: What drives a device.
DRIVES = set_of("motor drive servo engine actuator antrieb moteur shaker")
#: What a supply is told.
COMMANDS = frozenset({"pwm", "duty", "command", "cmd", "excitation"})
ROMANCE = set_of(
    "vitesse velocidad velocidade velocita couple force fuerza forza forca par coppia deplacement desplazamiento "
    "deslocamento spostamento posicion posicao posizione angle angulo courant corriente corrente "
    "скорость момент сила ток напряжение перемещение угол усилие predkosc rychlost hastighet"
)
GERMAN = {
    "field": ("strom", "spannung"),
    "slip": ("drehzahl", "geschwindigkeit"),
    "position": ("weg", "winkel", "hub"),
    "effort": ("moment", "kraft"),
}
GERMAN_OTHERS = tuple(
    "soll normal traegheits tragheits schub scher quer gewichts massen bezugs".split()
)
# Compounds that end like a signal and are none: an acceleration, a pressure, a power.
EASTERN_OTHERS = tuple(
    (
        "加速度 压力 壓力 圧力 应力 応力 功率 动力 电力 電力 误差 温度 频率 "
        "目标 目標 设定 指令 给定 命令 速度比 时间 時間 序号 编号 番号 效率 効率 "
        "摩擦系数 摩擦因数 摩擦係数 应变 ひずみ 次数 计数 サイクル数 サイクル回数"
    ).split()
)
